//! Scratch.
use kinora_lang::*;
fn main() {
    let path = std::env::args().nth(1).unwrap();
    let (files, name) = files::Folder::of(std::path::Path::new(&path)).unwrap();
    let loaded = files::load(&files, source::FileId(0), &name).unwrap();
    let tree = parse(&loaded.source);
    let mut over = Overrides::default();
    for a in std::env::args().skip(2) {
        if let Some(d) = a.strip_prefix("-D") {
            let (k, v) = d.split_once('=').unwrap();
            over.params.push((k.into(), v.into()));
        }
        if let Some(d) = a.strip_prefix("-S") {
            let (k, v) = d.split_once('=').unwrap();
            over.sets.push((k.into(), v.into()));
        }
        if let Some(d) = a.strip_prefix("-C") {
            over.camera = Some(d.into());
        }
    }
    let t = std::time::Instant::now();
    let result = eval(&tree, &files, &over);
    eprintln!("{:?}", t.elapsed());
    let quiet = std::env::var("Q").is_ok();
    let found = match &result {
        Ok(e) => {
            if !quiet {
                println!("{:#?}\n{:#?}", e.scene, e.params);
            } else {
                println!("ok {} nodes {} materials", e.scene.nodes.len(), e.scene.materials.len());
            }
            e.warnings.clone()
        }
        Err(d) => d.clone(),
    };
    let sources = [loaded.source.clone()];
    for d in diagnostic::list(found, 50).shown {
        if quiet {
            println!("{}", diagnostic::render_short(&d, &sources));
        } else {
            println!("{}", diagnostic::render(&d, &sources, diagnostic::Style::default()));
        }
    }
}
