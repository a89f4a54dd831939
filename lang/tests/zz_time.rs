use kinora_lang::source::{FileId, Source};
#[test]
fn time() {
    let text = include_str!("scenes/cornell.kin").repeat(1000);
    let t = std::time::Instant::now();
    let source = Source::new(FileId(0), "a", text.as_str());
    eprintln!("source {:?} {} bytes", t.elapsed(), text.len());
    let t = std::time::Instant::now();
    let tree = kinora_lang::parse(&source);
    eprintln!("parse {:?}", t.elapsed());
    let t = std::time::Instant::now();
    let n = tree.root().descendants_with_tokens().count();
    eprintln!("walk {:?} {n}", t.elapsed());
    let t = std::time::Instant::now();
    let f = tree.file();
    eprintln!("lower {:?} {}", t.elapsed(), f.items.len());
}
