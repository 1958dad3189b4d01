//! Fibre density of a groom and what light loses and gains on its way through it.
