//! kinora-translate
