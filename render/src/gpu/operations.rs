//! How many transcendental operations a shader executes, counted by the shader that runs: after every group of expressions that it
//! evaluates, their operations are added to a private variable of its own. Branches that are not taken do not count.

use naga::valid::{Capabilities, FunctionInfo, ModuleInfo, ValidationFlags, Validator};
use naga::{
    Arena, BinaryOperator, Block, Expression, Function, GlobalVariable, Handle, Literal, MathFunction,
    Module, Range, Span, Statement, TypeInner, UniqueArena,
};

use super::{Gpu, GpuError, kernel::Kernel};

/// Name of the `var<private>` of type u32 that a counted shader declares.
pub const COUNTER: &str = "operation_count";

/// Runs a compute shader whose operations are counted, one thread (64 a group) per answer.
///
/// `text` declares `var<private> operation_count: u32`, reads `inputs` as storage buffers of group 0, bindings 0, 1 and so on, and
/// writes `count` numbers of type u32 to the binding after them; these are returned.
///
/// # Errors
/// [`GpuError`] when the shader is refused, a buffer is too large or the device is lost.
pub fn run(
    gpu: &Gpu,
    text: &str,
    constants: &[(&str, f64)],
    inputs: &[&[u8]],
    count: u32,
) -> Result<Vec<u32>, GpuError> {
    let module = counted(text).map_err(|reason| GpuError::Refused {
        what: "a shader to be counted".to_owned(),
        reason,
    })?;
    let kernel = Kernel::of_module(gpu, "operations", module, constants)?;
    let mut buffers = Vec::with_capacity(inputs.len() + 1);
    for input in inputs {
        buffers.push(gpu.storage_of("counted input", input)?);
    }
    buffers.push(gpu.storage("operation counts", u64::from(count) * size_of::<u32>() as u64)?);
    let bindings: Vec<_> = (0..).zip(&buffers).collect();
    kernel.run(gpu, &kernel.bind(gpu, &bindings), count);
    gpu.read(&buffers[inputs.len()], count as usize)
}

/// The module of a shader text with the additions to its counter.
fn counted(text: &str) -> Result<Module, String> {
    let mut module = naga::front::wgsl::parse_str(text).map_err(|e| e.emit_to_string(text))?;
    let info: ModuleInfo = Validator::new(ValidationFlags::all(), Capabilities::all())
        .validate(&module)
        .map_err(|e| e.emit_to_string(text))?;
    let (counter, _) = module
        .global_variables
        .iter()
        .find(|(_, variable)| variable.name.as_deref() == Some(COUNTER))
        .ok_or_else(|| format!("it has no var<private> {COUNTER}"))?;
    for (handle, function) in module.functions.iter_mut() {
        count_function(function, &info[handle], &module.types, counter);
    }
    for (index, entry) in module.entry_points.iter_mut().enumerate() {
        count_function(
            &mut entry.function,
            info.get_entry_point(index),
            &module.types,
            counter,
        );
    }
    Ok(module)
}

fn count_function(
    function: &mut Function,
    info: &FunctionInfo,
    types: &UniqueArena<naga::Type>,
    counter: Handle<GlobalVariable>,
) {
    let costs: Vec<u32> = function
        .expressions
        .iter()
        .map(|(handle, expression)| match expression {
            Expression::Math { fun, .. } => {
                let components = match info[handle].ty.inner_with(types) {
                    TypeInner::Vector { size, .. } => *size as u32,
                    _ => 1,
                };
                operations(*fun, components)
            }
            _ => 0,
        })
        .collect();
    // The global is an expression of the function like any other.
    let pointer = function
        .expressions
        .append(Expression::GlobalVariable(counter), Span::UNDEFINED);
    count_block(&mut function.body, &costs, pointer, &mut function.expressions);
}

/// Transcendental operations of one call, per component of its result; a length is one square root.
fn operations(function: MathFunction, components: u32) -> u32 {
    use MathFunction as F;
    match function {
        F::Exp | F::Exp2 | F::Log | F::Log2 | F::Pow | F::Sqrt | F::InverseSqrt => components,
        F::Sin | F::Cos | F::Tan | F::Asin | F::Acos | F::Atan | F::Atan2 => components,
        F::Sinh | F::Cosh | F::Tanh | F::Asinh | F::Acosh | F::Atanh => components,
        F::Length | F::Distance | F::Normalize => 1,
        _ => 0,
    }
}

/// Adds to the counter after every group of expressions of the block, and of the blocks inside it.
fn count_block(
    block: &mut Block,
    costs: &[u32],
    pointer: Handle<Expression>,
    expressions: &mut Arena<Expression>,
) {
    for (mut statement, span) in std::mem::take(block).span_into_iter() {
        let mut evaluated = 0;
        match &mut statement {
            Statement::Emit(range) => evaluated = cost_of(range, costs),
            Statement::Block(inner) => count_block(inner, costs, pointer, expressions),
            Statement::If { accept, reject, .. } => {
                count_block(accept, costs, pointer, expressions);
                count_block(reject, costs, pointer, expressions);
            }
            Statement::Switch { cases, .. } => {
                for case in cases {
                    count_block(&mut case.body, costs, pointer, expressions);
                }
            }
            Statement::Loop { body, continuing, .. } => {
                count_block(body, costs, pointer, expressions);
                count_block(continuing, costs, pointer, expressions);
            }
            _ => {}
        }
        block.push(statement, span);
        if evaluated > 0 {
            push_addition(block, evaluated, pointer, expressions);
        }
    }
}

fn cost_of(range: &Range<Expression>, costs: &[u32]) -> u32 {
    range.clone().map(|handle| costs[handle.index()]).sum()
}

/// `counter = counter + amount`.
fn push_addition(
    block: &mut Block,
    amount: u32,
    pointer: Handle<Expression>,
    expressions: &mut Arena<Expression>,
) {
    let right = expressions.append(Expression::Literal(Literal::U32(amount)), Span::UNDEFINED);
    let first = expressions.len();
    let left = expressions.append(Expression::Load { pointer }, Span::UNDEFINED);
    let value = expressions.append(
        Expression::Binary {
            op: BinaryOperator::Add,
            left,
            right,
        },
        Span::UNDEFINED,
    );
    block.push(Statement::Emit(expressions.range_from(first)), Span::UNDEFINED);
    block.push(Statement::Store { pointer, value }, Span::UNDEFINED);
}
