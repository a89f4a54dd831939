//! Files: beside their place first, and then all at once.

use std::fs::Permissions;
use std::io::Write;
use std::path::Path;

/// Writes a file that is there, with the permissions that it had. A link stays one.
///
/// # Errors
/// The file must not be written, or its folder cannot.
pub fn write(path: &Path, text: &str) -> Result<(), String> {
    let write = || -> std::io::Result<()> {
        let path = path.canonicalize()?;
        let permissions = std::fs::metadata(&path)?.permissions();
        if permissions.readonly() {
            return Err(std::io::ErrorKind::PermissionDenied.into());
        }
        put(&path, text.as_bytes(), Some(permissions))
    };
    write().map_err(|error| format!("cannot write `{}`: {error}", path.display()))
}

/// Writes a file that may be new.
///
/// # Errors
/// As [`write`].
pub fn create(path: &Path, text: &str) -> Result<(), String> {
    if path.exists() {
        // What is no regular file, such as /dev/stdout, has no place beside it.
        return match path.is_file() {
            true => write(path, text),
            false => std::fs::write(path, text).map_err(|error| format!("cannot write `{}`: {error}", path.display())),
        };
    }
    put(path, text.as_bytes(), None).map_err(|error| format!("cannot write `{}`: {error}", path.display()))
}

/// Writes a file of the program's own, whatever is there.
///
/// # Errors
/// Its folder cannot be written to.
#[cfg(any(feature = "physics", feature = "viewer"))]
pub fn create_bytes(path: &Path, bytes: &[u8]) -> Result<(), String> {
    put(path, bytes, None).map_err(|error| format!("cannot write `{}`: {error}", path.display()))
}

fn put(path: &Path, bytes: &[u8], permissions: Option<Permissions>) -> std::io::Result<()> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut builder = tempfile::Builder::new();
    builder.prefix(".kinora-").suffix(".tmp");
    #[cfg(unix)]
    if permissions.is_none() {
        // As any new file: what the system's mask leaves of it.
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(Permissions::from_mode(0o666));
    }
    let mut beside = builder.tempfile_in(folder)?;
    beside.write_all(bytes)?;
    if let Some(permissions) = permissions {
        beside.as_file().set_permissions(permissions)?;
    }
    beside.as_file().sync_all()?;
    beside.persist(path)?;
    Ok(())
}
