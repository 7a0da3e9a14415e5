//! Tables of settings whose keys stand beside their defaults and bounds.

/// A table of a configuration: each key with its default beside it, and its [`Bound`](crate::config::Bound) where it has one; what does not stand in a file has that
/// default, and a key that is not one of them is refused. With `impl Validate` behind the table the bounds are all that is asked of it; elsewhere `outside` gives
/// what is outside of them.
///
/// ```
/// use dpn_core::config::{Limit, Validate};
///
/// dpn_core::settings!(
///     /// How a solver ends.
///     #[derive(Copy)]
///     pub struct SolverConfig {
///         /// Steps, at most.
///         pub most_steps: usize = 8 => 1..=100,
///         /// It ends when a step lowers the cost by less than this share.
///         pub tolerance: f64 = 1e-2 => Limit::Positive,
///         /// Whether it says why.
///         pub speaks: bool = false,
///     }
///     impl Validate
/// );
/// assert_eq!(SolverConfig::default().most_steps, 8);
/// assert!(SolverConfig::default().faults().is_empty());
/// let faults = SolverConfig { most_steps: 0, ..SolverConfig::default() }.faults();
/// assert_eq!(faults[0].to_string(), "`most_steps` is 0, but must be 1 to 100");
/// ```
#[macro_export]
macro_rules! settings {
    (
        $(#[$doc:meta])* pub struct $name:ident { $($(#[$kdoc:meta])* pub $key:ident: $kind:ty = $value:expr $(=> $bound:expr)?),+ $(,)? }
        $(impl $validate:ident)?
    ) => {
        $(#[$doc])*
        #[derive(Debug, Clone, PartialEq, ::serde::Serialize, ::serde::Deserialize)]
        #[serde(deny_unknown_fields, default)]
        pub struct $name {
            $($(#[$kdoc])* pub $key: $kind,)+
        }

        impl ::std::default::Default for $name {
            fn default() -> Self {
                Self { $($key: $value,)+ }
            }
        }

        impl $name {
            /// Keys outside the bounds that stand beside them.
            #[allow(dead_code, unused_mut, reason = "of a table without bounds")]
            pub(crate) fn outside(&self) -> $crate::config::ConfigFaults {
                let mut faults = $crate::config::ConfigFaults::default();
                $($($crate::config::Bound::judge($bound, stringify!($key), self.$key, &mut faults);)?)+
                faults
            }
        }

        $(impl $crate::config::$validate for $name {
            fn faults(&self) -> ::std::vec::Vec<$crate::config::ConfigFault> {
                self.outside().0
            }
        })?
    };
}
