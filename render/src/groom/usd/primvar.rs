//! How the numbers of a primvar spread over the curves of its prim: constant, uniform, varying or vertex.

use std::borrow::Cow;

use super::basis::Shape;
use super::layer::Prim;

/// A place on one of a prim's curves.
#[derive(Clone, Copy)]
pub(super) struct Place {
    /// Index of the curve in its prim.
    pub curve: usize,
    /// Its shape.
    pub shape: Shape,
    /// Its first control point.
    pub first: usize,
    /// Its first `varying` value.
    pub first_varying: usize,
    /// Segment of the curve.
    pub segment: usize,
    /// Parameter within the segment.
    pub t: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Spread {
    Constant,
    Uniform,
    Varying,
    Vertex,
}

/// A primvar that fits the curves of its prim.
pub(super) struct Primvar<'a> {
    numbers: Cow<'a, [f64]>,
    spread: Spread,
}

impl<'a> Primvar<'a> {
    /// The primvar `name` of a prim with curves of `shapes`, of `components` numbers a value; none where it is not there or empty.
    ///
    /// The interpolation is the one it states, else, or where that does not fit, the one that its number of values fits.
    ///
    /// # Errors
    /// The reason why it cannot be used.
    pub fn of(
        prim: &'a Prim,
        name: &str,
        components: usize,
        time: Option<f64>,
        shapes: &[Shape],
    ) -> Result<Option<Self>, String> {
        let Some(numbers) = prim.numbers(name, time).filter(|numbers| !numbers.is_empty()) else {
            return Ok(None);
        };
        let numbers = match prim.numbers(&format!("{name}:indices"), time) {
            Some(indices) => Cow::Owned(indexed(numbers, indices, components)?),
            None => Cow::Borrowed(numbers),
        };
        let vertex: usize = shapes.iter().map(|shape| shape.count).sum();
        let varying: usize = shapes.iter().map(|shape| shape.varying()).sum();
        let counts = [
            (Spread::Vertex, "vertex", vertex),
            (Spread::Varying, "varying", varying),
            (Spread::Uniform, "uniform", shapes.len()),
            (Spread::Constant, "constant", 1),
        ];
        let count = numbers.len() / components;
        let whole = numbers.len().is_multiple_of(components);
        let stated = prim.attributes[name].interpolation.as_deref();
        let fitting = counts
            .iter()
            .find(|(_, name, n)| stated == Some(name) && *n == count)
            .or_else(|| counts.iter().find(|(_, _, n)| *n == count))
            .filter(|_| whole);
        match fitting {
            Some(&(spread, ..)) => Ok(Some(Self { numbers, spread })),
            None => Err(format!(
                "{} numbers of {components} a value fit no interpolation ({vertex} vertex, {varying} varying, {} uniform or 1 constant values)",
                numbers.len(),
                shapes.len()
            )),
        }
    }

    /// Its numbers, value after value.
    pub fn numbers(&self) -> &[f64] {
        &self.numbers
    }

    /// The value at a place; `N` is the number of components that it was read with.
    pub fn at<const N: usize>(&self, place: &Place) -> [f64; N] {
        let value = |i: usize| -> [f64; N] { std::array::from_fn(|c| self.numbers[N * i + c]) };
        match self.spread {
            Spread::Constant => value(0),
            Spread::Uniform => value(place.curve),
            Spread::Vertex => {
                let control = |i| value(place.first + i);
                place.shape.at(place.segment, place.t, control)
            }
            Spread::Varying => {
                let ends = |i| value(place.first_varying + i % place.shape.varying());
                let (a, b) = (ends(place.segment), ends(place.segment + 1));
                match place.t {
                    0.0 => a,
                    1.0 => b,
                    t => std::array::from_fn(|c| (1.0 - t) * a[c] + t * b[c]),
                }
            }
        }
    }
}

/// The values that the indices of an indexed primvar name.
fn indexed(numbers: &[f64], indices: &[f64], components: usize) -> Result<Vec<f64>, String> {
    let mut out = Vec::with_capacity(indices.len() * components);
    for index in indices {
        let first = (*index >= 0.0).then_some(*index as usize * components);
        let value = first.and_then(|first| numbers.get(first..first.checked_add(components)?));
        let Some(value) = value else {
            let count = numbers.len() / components;
            return Err(format!("index {index} names none of its {count} values"));
        };
        out.extend_from_slice(value);
    }
    Ok(out)
}
