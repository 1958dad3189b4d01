//! Pictures: linear RGBA in memory, PNG and EXR on disk.
