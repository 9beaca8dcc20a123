//! The `microtome` command: arguments in, exit code out.

fn main() -> std::process::ExitCode {
    microtome::cli::main()
}
