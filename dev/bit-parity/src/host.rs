//! Answers a request of [`sinew_bit_parity::answer`] on the machine for which this program is compiled.

use std::io::{BufWriter, Read as _, Write as _, stdin, stdout};
use std::process::ExitCode;

use sinew_bit_parity::answer;

use crate::{BODIES, BUFFER_LEN, COORDINATES, DOFS};

pub(crate) fn main() -> ExitCode {
    let (mut input, mut output) = (stdin().lock(), BufWriter::new(stdout().lock()));
    let mut buffer = vec![0; BUFFER_LEN];
    let result = answer::<BODIES, DOFS, COORDINATES>(
        &mut buffer,
        |bytes| input.read_exact(bytes).map_err(|_| "the request ends too early"),
        |bytes| output.write_all(bytes).map_err(|_| "the answer cannot be written"),
    )
    .and_then(|()| output.flush().map_err(|_| "the answer cannot be written"));
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(problem) => {
            eprintln!("error: {problem}");
            ExitCode::FAILURE
        }
    }
}
