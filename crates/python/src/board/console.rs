//! Requests to a running console.

use pyo3::prelude::*;
use sinew_board_client::console::{Reply, Request, ask, consoles};

use super::BoardError;
use crate::error::value;

/// A running console of this user.
#[pyclass(frozen, module = "sinew_motion._sinew_motion")]
pub(crate) struct NativeConsole {
    name: String,
}

/// Finds a running console by its name; without a name, the only running console.
#[pyfunction]
pub(crate) fn open_console(name: Option<String>) -> PyResult<NativeConsole> {
    Ok(NativeConsole { name: find(name)? })
}

/// Returns the name of a running console: the given name, or that of the only running console.
pub(super) fn find(name: Option<String>) -> PyResult<String> {
    let mut names = consoles();
    Ok(match name {
        Some(name) if names.contains(&name) => name,
        Some(name) => {
            let running = if names.is_empty() { "none runs".to_owned() } else { names.join(", ") };
            return Err(BoardError::new_err(format!("there is no console `{name}`: {running}")));
        }
        None if names.len() > 1 => {
            return Err(BoardError::new_err(format!("several consoles run: {}", names.join(", "))));
        }
        None => names
            .pop()
            .ok_or_else(|| BoardError::new_err("no console runs: `sinew console` starts one"))?,
    })
}

impl NativeConsole {
    fn ask(&self, py: Python<'_>, request: Request) -> PyResult<String> {
        let name = self.name.clone();
        let reply = py
            .detach(|| ask(&name, &request))
            .map_err(|error| BoardError::new_err(format!("the console {}: {error}", self.name)))?;
        let Reply { ok, text } = reply;
        if ok { Ok(text) } else { Err(BoardError::new_err(text)) }
    }
}

#[pymethods]
impl NativeConsole {
    #[getter]
    fn name(&self) -> &str {
        &self.name
    }

    fn home(&self, py: Python<'_>) -> PyResult<String> {
        self.ask(py, Request::Home)
    }

    fn jog(&self, py: Python<'_>, joint: String, by: f64) -> PyResult<String> {
        if !by.is_finite() {
            return Err(value(format!("by: expected a finite number, found {by}")));
        }
        self.ask(py, Request::Jog { joint, by })
    }

    fn stop(&self, py: Python<'_>) -> PyResult<String> {
        self.ask(py, Request::Stop)
    }

    fn estop(&self, py: Python<'_>) -> PyResult<String> {
        self.ask(py, Request::EStop)
    }
}
