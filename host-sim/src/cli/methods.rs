//! Options that name methods.

use anyhow::bail;
use clap::ValueEnum;
use clap::builder::PossibleValue;
use sinew_core::tracker::SettingError;
use sinew_evaluation::{MethodName, Setup, SetupError};
use sinew_host_util::command::note;

/// A method, or all of them.
#[derive(Debug, Clone, Copy)]
pub(super) enum MethodArg {
    /// All methods except `accumulated`.
    All,
    /// A single method.
    One(MethodName),
}

impl ValueEnum for MethodArg {
    fn value_variants<'a>() -> &'a [Self] {
        const VARIANTS: &[MethodArg] = &[
            MethodArg::One(MethodName::Local),
            MethodArg::One(MethodName::World),
            MethodArg::One(MethodName::Egocentric),
            MethodArg::One(MethodName::Accumulated),
            MethodArg::One(MethodName::LinearCompensation),
            MethodArg::One(MethodName::ManifoldProjection),
            MethodArg::One(MethodName::ResolvedAcceleration),
            MethodArg::One(MethodName::Recommended),
            MethodArg::All,
        ];
        VARIANTS
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        match self {
            Self::All => Some(PossibleValue::new("all").help("All of these except `accumulated`")),
            Self::One(method) => Some(PossibleValue::new(method.as_str()).help(method.summary())),
        }
    }
}

/// Returns the methods that the arguments name.
pub(super) fn methods(args: &[MethodArg]) -> Vec<MethodName> {
    let named = |arg: &MethodArg| match arg {
        MethodArg::One(method) => vec![*method],
        MethodArg::All => MethodName::ALL.to_vec(),
    };
    args.iter().flat_map(named).collect()
}

/// If a method fixes a setting itself: refuses the setting if this is the only method; with several methods, prints
/// that this method ignores the setting.
pub(super) fn check_fixed(setup: &Setup, methods: &[MethodName]) -> anyhow::Result<()> {
    for method in methods {
        let mut of_method = setup.clone();
        of_method.controller.method = *method;
        match of_method.check() {
            Err(SetupError::Controller(SettingError::Fixed { key })) if methods.len() > 1 => {
                note(format_args!(
                    "{method} keeps its own controller.{key}: the setting applies to the other methods"
                ));
            }
            Err(error @ SetupError::Controller(SettingError::Fixed { .. })) => bail!(error),
            _ => {}
        }
    }
    Ok(())
}
