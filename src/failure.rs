//! The error type for a program's `main`, with readable messages.

use std::error::Error;
use std::fmt;

/// Any error: `main() -> Result<(), Failure>` prints the message of the error and those of its causes, where
/// `Box<dyn Error>` prints its debug form. `?` converts any error or text into it.
///
/// ```
/// use pullback::Failure;
/// use pullback::prelude::*;
///
/// let loose = || -> Result<(), Failure> { Err("the spring is not hooked in")? };
/// let said = loose().unwrap_err();
/// assert_eq!(format!("{said} {said:?}"), "the spring is not hooked in the spring is not hooked in");
/// ```
pub struct Failure(Box<dyn Error>);

impl<E: Into<Box<dyn Error>>> From<E> for Failure {
    fn from(error: E) -> Self {
        Self(error.into())
    }
}

impl fmt::Debug for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut said = self.0.to_string();
        let mut cause = self.0.source();
        while let Some(error) = cause {
            let words = error.to_string();
            if !said.contains(&words) {
                said = format!("{said}: {words}");
            }
            cause = error.source();
        }
        f.write_str(&said)
    }
}
