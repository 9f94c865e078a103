//! One line per leaf.

use crate::support::*;

#[test]
fn charts() {
    check::chart(&WienerMilenkovic).assert();
}

#[test]
fn maps() {
    check::map(&Complement).assert();
    let turn = Vector3::new(0.4, -1.1, 0.7);
    check::map(&Increment::<6>::from(&turn)).assert();
    check::map(&Increment::<3>::from(&turn)).assert();
}
