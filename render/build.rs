//! Lists every WGSL file below `shaders/` with its text, for `gpu::shader`.

use std::fmt::Write;
use std::path::Path;
use std::{env, fs, io};

fn main() -> io::Result<()> {
    let shaders = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shaders");
    let mut table = String::from("&[\n");
    for folder in ["lib", "pass"] {
        println!("cargo::rerun-if-changed={}", shaders.join(folder).display());
        let mut names: Vec<_> = fs::read_dir(shaders.join(folder))?
            .map(|entry| entry.map(|entry| entry.file_name()))
            .collect::<io::Result<_>>()?;
        names.sort();
        for name in names {
            let file = shaders.join(folder).join(&name).canonicalize()?;
            let name = name.display();
            writeln!(
                table,
                "    ({:?}, include_str!({file:?})),",
                format!("{folder}/{name}")
            )
            .map_err(io::Error::other)?;
        }
    }
    table.push_str("]\n");
    let out = env::var_os("OUT_DIR").ok_or_else(|| io::Error::other("cargo sets OUT_DIR"))?;
    fs::write(Path::new(&out).join("shaders.rs"), table)
}
