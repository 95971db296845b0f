//! A thread with enough stack for a controller.

/// Stack size. A controller with all its capacities is built on the stack.
const STACK_BYTES: usize = 256 << 20;

/// Runs code that builds a controller, on a thread with enough stack.
pub(super) fn with_stack<T: Send>(
    run: impl FnOnce() -> anyhow::Result<T> + Send,
) -> anyhow::Result<T> {
    std::thread::scope(|scope| {
        let builder = std::thread::Builder::new().stack_size(STACK_BYTES);
        let done = builder.spawn_scoped(scope, run)?.join();
        done.unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    })
}
