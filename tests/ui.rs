//! The editor, driven through its accessibility tree.
