//! The permission to erase flash.

/// Proof that no drive may move. Every function that erases flash has a parameter `&Disarmed`.
///
/// There is only one value: [`Store::open`](crate::Store::open) creates it at power-on, when nothing is armed. Other
/// code can neither create nor copy it. Its owner is the supervisor, which lends it only while the rig is limp. While
/// servos hold or move, no code therefore has the permission to erase.
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
