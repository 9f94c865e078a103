//! Systems and their matrices.

mod pattern;
