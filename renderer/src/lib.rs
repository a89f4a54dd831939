//! kinora-renderer
