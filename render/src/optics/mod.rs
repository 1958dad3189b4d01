//! Float64 reference of everything the shaders compute: numerical integration, independent of the shaders' closed forms.
//!
//! Every azimuthal integral is taken over the offset h across the fibre, where d'Eon 2011 (Eq 10) has no root to find and no
//! caustic to smooth; every longitudinal one over theta_i. Both are adaptive and take a relative tolerance.
//!
//! | file | holds |
//! |---|---|
//! | [`fibre`] | what goes in ([`Fibre`], [`SrbfLight`], [`Direction`]), the door that refuses bad values, [`Lobes`] |
//! | [`quadrature`], [`bessel`], [`circular`] | adaptive integration, scaled I0, circular Gaussians and their convolutions |
//! | [`fresnel`], [`longitudinal`], [`azimuthal`] | F, M and N, one factor each |
//! | [`single`] | single scattering of one fibre: under an SRBF light, a uniform environment, a direction |
//! | [`averages`] | a_f, a_b, average shifts and widths (Xu 2011, Eq 32) |
//! | [`dual`] | global and local multiple scattering (Xu 2011, Eq 27 to 31), A_b, Delta_b, sigma_b, k and rho |
//! | [`sample`] | directions drawn from what a fibre scatters |
//! | [`seen`] | the colour of deep hair in white light, and the absorption that gives a colour |
//! | [`deon`], [`kajiya_kay`] | the other two models |
//!
//! Conventions: radians; beta is a standard deviation in theta_h; M integrates to one over theta_i; sigma_a is per fibre radius.
//! Papers: Xu 2011 (Interactive Hair Rendering and Appearance Editing under Environment Lighting), Marschner 2003 (Light
//! Scattering from Human Hair Fibers), Zinke 2008 (Dual Scattering Approximation), d'Eon 2011 (An Energy-Conserving Hair
//! Reflectance Model), Kajiya and Kay 1989.

pub mod averages;
pub mod azimuthal;
pub mod bessel;
pub mod circular;
pub mod deon;
pub mod dual;
pub mod fibre;
pub mod fresnel;
pub mod kajiya_kay;
pub mod longitudinal;
pub mod quadrature;
pub mod sample;
pub mod seen;
pub mod single;

pub use averages::{Averages, scattering_averages};
pub use dual::{global_scattering, local_scattering};
pub use fibre::{Direction, Fibre, Lobe, Lobes, OpticsError, Rgb, SrbfLight};
pub use single::{furnace_radiance, scattering_function, single_scattering};
