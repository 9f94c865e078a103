//! Schemes: tables, spectra, what they claim.

mod conformance;
mod radau5;
mod spectrum;
mod tables;

/// Words of schemes, with several numbers where a family takes them.
const WORDS: [&str; 20] = [
    "newmark",
    "newmark:0.3025:0.6",
    "newmark:0.16666666666666666:0.5",
    "newmark:0.08333333333333333:0.5",
    "newmark:0.25:0.6",
    "hht:-0.1",
    "hht:0.5",
    "hht:0.8",
    "wbz:0",
    "wbz:0.5",
    "wbz:0.8",
    "ga:0",
    "ga:0.5",
    "ga:0.8",
    "ga:1",
    "bathe",
    "bathe:0.5",
    "bathe:0.3",
    "radau",
    "central-difference",
];
