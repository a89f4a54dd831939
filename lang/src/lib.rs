//! kinora-lang
