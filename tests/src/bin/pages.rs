//! Writes the lists in the committed pages anew: `cargo run --release -p tests --bin pages`.

fn main() -> std::io::Result<()> {
    for page in harness::pages::pages() {
        if page.stands != page.written {
            std::fs::write(&page.path, &page.written)?;
            println!("{} is written anew", page.path.display());
        }
    }
    Ok(())
}
