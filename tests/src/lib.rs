//! kinora-tests
