//! What the tests share: data folder, comparators with their negative controls, poison values.
