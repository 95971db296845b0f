//! The permission to erase.

/// Proof that no drive may move. All that may erase asks for `&Disarmed`.
///
/// There is one of it: [`Store::open`](crate::Store::open) makes it at power-on, where nothing is armed. It can be
/// neither made nor copied elsewhere. Its owner is the supervisor, which lends it while the rig is limp and at no
/// other time. So a state in which servos hold or move cannot call what erases.
///
/// ```compile_fail
/// let mine = sinew_storage::Disarmed(());
/// ```
///
/// The owner's side, in short:
/// ```
/// use sinew_storage::Disarmed;
///
/// struct Supervisor {
///     limp: bool,
///     disarmed: Disarmed,
/// }
///
/// impl Supervisor {
///     /// Arming needs `&mut self`: it cannot happen while somebody has what is lent here.
///     fn disarmed(&self) -> Option<&Disarmed> {
///         self.limp.then_some(&self.disarmed)
///     }
/// }
/// ```
#[derive(Debug)]
pub struct Disarmed(());

impl Disarmed {
    pub(crate) fn at_power_on() -> Self {
        Self(())
    }
}
