//! What a program's `main` returns, so that its user reads words.

use std::error::Error;
use std::fmt;

/// Any error, as `main` returns it: `main() -> Result<(), Failure>` ends with the error's words and
/// those of its causes, where `Box<dyn Error>` shows how it is made up. `?` turns any error, and a
/// text, into one.
///
/// ```
/// use pullback::prelude::*;
///
/// let loose = || -> Result<(), Failure> { Err("the spring is not hooked in")? };
/// let said = format!("{:?}", loose().unwrap_err());
/// assert_eq!(said, "the spring is not hooked in");
/// ```
pub struct Failure(Box<dyn Error>);

impl<E: Into<Box<dyn Error>>> From<E> for Failure {
    fn from(error: E) -> Self {
        Self(error.into())
    }
}

impl fmt::Debug for Failure {
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
