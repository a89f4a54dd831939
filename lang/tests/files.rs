//! The door to the disk stays shut for what is outside of the project.

use kinora_lang::files::{FileError, Files, Folder, Memory, load, resolve};
use kinora_lang::source::FileId;

#[test]
fn paths() {
    let check = |written: &str, expected: Result<&str, &str>| {
        let found = resolve("scenes/deep/a.kin", written);
        assert_eq!(found.as_deref().map_err(FileError::code), expected, "{written}");
    };
    check("b.kin", Ok("scenes/deep/b.kin"));
    check("./x//b.kin", Ok("scenes/deep/x/b.kin"));
    check("../b.kin", Ok("scenes/b.kin"));
    check("../../b.kin", Ok("b.kin"));
    check("/lib/b.kin", Ok("lib/b.kin"));
    check("../../../b.kin", Err("E0703"));
    check("/../b.kin", Err("E0703"));
    check("a/../../../../b.kin", Err("E0703"));
    check("", Err("E0704"));
    check("//server/share/b.kin", Err("E0704"));
    check("C:/b.kin", Err("E0704"));
    check("..\\b.kin", Err("E0704"));
    check("https://example.org/b.kin", Err("E0704"));
    check("CON", Err("E0704"));
    check("lib/nul.kin", Err("E0704"));
    check("com1", Err("E0704"));
    check("b\0.kin", Err("E0704"));
    check("console.kin", Ok("scenes/deep/console.kin"));
}

#[test]
fn memory() {
    let files = Memory::new([("lib/a.kin", "lang 1".as_bytes()), ("bad.kin", b"\xE9")]);
    assert_eq!(files.read("lib/a.kin").as_deref(), Ok("lang 1".as_bytes()));
    assert_eq!(files.read("lib/b.kin").map_err(|error| error.code()), Err("E0701"));
    assert_eq!(files.read("lib/A.kin").map_err(|error| error.code()), Err("E0708"));
    assert_eq!(files.read_at_most("lib/a.kin", 5).map_err(|error| error.code()), Err("E0712"));
    assert_eq!(files.read("../a.kin").map_err(|error| error.code()), Err("E0703"));
    assert_eq!(
        load(&files, FileId(0), "bad.kin").map(|loaded| loaded.error.map(|error| error.code)),
        Ok(Some("E0119"))
    );
    let asked: Vec<(String, bool)> = files.dependencies().into_iter().map(|file| (file.path, file.found)).collect();
    let expected =
        [("../a.kin", false), ("bad.kin", true), ("lib/A.kin", false), ("lib/a.kin", false), ("lib/b.kin", false)];
    assert_eq!(asked, expected.map(|(path, found)| (path.to_string(), found)));
}

#[test]
fn folder() {
    let base = std::env::temp_dir().join(format!("kinora-files-{}", std::process::id()));
    let project = base.join("project");
    std::fs::create_dir_all(project.join("scenes")).unwrap();
    std::fs::write(base.join("secret"), "secret").unwrap();
    std::fs::write(project.join("kinora.toml"), "").unwrap();
    std::fs::write(project.join("scenes/a.kin"), "lang 1").unwrap();
    let (files, name) = Folder::of(&project.join("scenes/a.kin")).unwrap();
    assert_eq!(name, "scenes/a.kin");
    assert_eq!(files.root(), project.canonicalize().unwrap());
    let code = |path: &str| files.read(path).map(|bytes| bytes.to_vec()).map_err(|error| error.code());
    assert_eq!(code("scenes/a.kin"), Ok(b"lang 1".to_vec()));
    assert_eq!(code("scenes/b.kin"), Err("E0701"));
    assert_eq!(code("scenes/a.kin/b"), Err("E0701"));
    assert_eq!(code("Scenes/A.kin"), Err("E0708"));
    let named = files.read("scenes/A.KIN").map_err(|error| error.message());
    assert_eq!(named, Err("file is named `scenes/a.kin`".to_string()));
    assert_eq!(code("../secret"), Err("E0703"));
    assert_eq!(code("scenes"), Err("E0711"));
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(base.join("secret"), project.join("out")).unwrap();
        std::os::unix::fs::symlink("scenes/a.kin", project.join("in")).unwrap();
        assert_eq!(code("out"), Err("E0705"));
        assert_eq!(code("in"), Ok(b"lang 1".to_vec()));
        std::os::unix::fs::symlink(&base, project.join("away")).unwrap();
        assert_eq!(code("away/Secret"), Err("E0705"));
    }
    std::fs::remove_dir_all(&base).unwrap();
}
