//! The tables of albedos: made again in part, against the published numbers, and between their nodes.

use kinora_kernel::albedo::{ENTRIES, entry, tables};

#[test]
fn tables_are_what_they_were_made_from() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/data/albedo.f32");
    if std::env::var_os("KINORA_BLESS").is_some() {
        let threads: Vec<_> = (0..4)
            .map(|part| std::thread::spawn(move || (ENTRIES * part / 4..ENTRIES * (part + 1) / 4).map(entry).collect()))
            .collect();
        let values: Vec<Vec<f32>> = threads.into_iter().map(|t| t.join().expect("a part is computed")).collect();
        let bytes: Vec<u8> = values.concat().iter().flat_map(|v| v.to_le_bytes()).collect();
        std::fs::write(path, bytes).expect("the tables can be written");
        return;
    }
    assert_eq!(tables().len(), ENTRIES as usize);
    // A prime step visits every table at all kinds of nodes.
    for i in (0..ENTRIES).step_by(97) {
        let (kept, made) = (tables()[i as usize], entry(i));
        assert!((kept - made).abs() <= 1e-6, "entry {i}: {kept} is kept, {made} is right");
    }
}
