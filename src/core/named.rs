//! Enums whose variants have names.

/// An enum whose variants are spelt in one way in files, flags and texts: gives it `ALL`, `name`, `names`, `called` and `Display`.
///
/// ```
/// dpn_core::named!(
///     /// A side.
///     #[derive(PartialOrd, Ord)]
///     pub enum Side {
///         /// Left.
///         Left = "left",
///         /// Right.
///         Right = "right",
///     }
/// );
/// assert_eq!(Side::ALL.map(Side::name), ["left", "right"]);
/// ```
#[macro_export]
macro_rules! named {
    ($(#[$doc:meta])* pub enum $name:ident { $($(#[$vdoc:meta])* $variant:ident = $text:literal),+ $(,)? }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        pub enum $name {
            $($(#[$vdoc])* $variant,)+
        }

        impl $name {
            /// All of them, in order.
            pub const ALL: [Self; [$($text),+].len()] = [$(Self::$variant),+];

            /// The spelling in files, flags and texts.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $text,)+
                }
            }

            /// All spellings, for messages.
            pub fn names() -> String {
                Self::ALL.map(Self::name).join(", ")
            }

            /// The one that is spelt so.
            pub fn called(name: &str) -> Option<Self> {
                Self::ALL.into_iter().find(|one| one.name() == name)
            }
        }

        impl ::std::fmt::Display for $name {
            fn fmt(&self, f: &mut ::std::fmt::Formatter<'_>) -> ::std::fmt::Result {
                f.write_str(self.name())
            }
        }
    };
}
