//! Data sets: select, sample, split, de-duplicate, balance, freeze, verify, export. Not built yet.
