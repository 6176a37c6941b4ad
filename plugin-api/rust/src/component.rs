//! How a library exports its codels.

use std::ffi::CStr;

use crate::abi::CodelDescriptor;

/// A function marked with [`codel`](crate::codel), represented by a type of the same name.
pub trait Codel {
    /// Its entry in the exported table.
    const DESCRIPTOR: CodelDescriptor;
}

/// Makes the library a component: exports its `.gen` text and the table of its codels.
///
/// Call it once in a library, in any module. The path of the description is relative to the file
/// that calls the macro. Files that the description includes are not embedded: the host searches
/// them beside the library and along its include path.
///
/// ```text
/// genom::component! {
///     description: "../demo.gen",
///     codels: [demo_init, motion::demo_servo],
///     exceptions: [OutOfRange],
/// }
/// ```
#[macro_export]
macro_rules! component {
    (
        description: $description:literal,
        codels: [$($codel:ty),* $(,)?]
        $(, exceptions: [$($exception:ty),* $(,)?])? $(,)?
    ) => {
        const _: () = {
            const TEXT: &[u8] = include_bytes!($description);

            #[unsafe(no_mangle)]
            #[allow(non_upper_case_globals)]
            static genom_description: [u8; TEXT.len() + 1] = $crate::rt::terminated(TEXT);

            #[unsafe(no_mangle)]
            #[allow(non_upper_case_globals)]
            static genom_component: $crate::abi::Component = $crate::abi::Component {
                abi_major: $crate::abi::ABI_MAJOR,
                abi_minor: $crate::abi::ABI_MINOR,
                size: size_of::<$crate::abi::Component>() as u32,
                description: (&raw const genom_description).cast(),
                codels: $crate::abi::List::new(&[$(<$codel as $crate::Codel>::DESCRIPTOR),*]),
                exceptions: $crate::abi::List::new(
                    const {
                        &[$($(
                            <$exception as $crate::Exception>::TYPE
                        ),*)?]
                    },
                ),
            };
        };
    };
}

/// A text followed by a NUL, as an array for a static.
#[must_use]
pub const fn terminated<const N: usize>(text: &[u8]) -> [u8; N] {
    let mut bytes = [0; N];
    let mut i = 0;
    while i < text.len() {
        bytes[i] = text[i];
        i += 1;
    }
    bytes
}

/// Converts a text that ends with its only NUL to a C string. Any other text is a compile-time
/// error.
#[must_use]
pub const fn c_str(text: &'static str) -> &'static CStr {
    match CStr::from_bytes_with_nul(text.as_bytes()) {
        Ok(text) => text,
        Err(_) => invalid_name(),
    }
}

#[allow(clippy::panic, reason = "only ever evaluated by the compiler")]
const fn invalid_name() -> ! {
    panic!("a name contains a NUL")
}
