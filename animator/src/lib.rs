//! kinora-animator
