//! Set-up that several tests share.

pub mod dynamics;
pub mod linear_solver;
pub mod statics;

/// What is refused, row by row, with texts that its error has.
macro_rules! refused {
    ($($outcome:expr => $texts:expr),* $(,)?) => {$(
        let Err(error) = $outcome else {
            panic!("accepted: {}", stringify!($outcome));
        };
        let error = error.to_string();
        for text in $texts {
            assert!(error.contains(text), "`{text}` is not in: {error}");
        }
    )*};
}
pub(crate) use refused;
