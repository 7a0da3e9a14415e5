//! Tables of settings whose keys stand beside their defaults.

/// A table of a configuration: each key with its default beside it; what does not stand in a file has that, and a key that is not one of them is refused.
///
/// ```
/// dpn_core::settings!(
///     /// How a solver ends.
///     #[derive(Copy)]
///     pub struct SolverConfig {
///         /// Steps, at most.
///         pub most_steps: usize = 8,
///         /// It ends when a step lowers the cost by less than this share.
///         pub tolerance: f64 = 1e-2,
///     }
/// );
/// assert_eq!(SolverConfig::default().most_steps, 8);
/// ```
#[macro_export]
macro_rules! settings {
    ($(#[$doc:meta])* pub struct $name:ident { $($(#[$kdoc:meta])* pub $key:ident: $kind:ty = $value:expr),+ $(,)? }) => {
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
    };
}
