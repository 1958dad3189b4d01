//! Float64 reference of everything the shaders compute: numerical integration, independent of the shaders' closed forms.
