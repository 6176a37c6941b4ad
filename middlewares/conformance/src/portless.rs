//! Middlewares for tests of what is not about ports.

/// Has these middlewares refuse every port. Where it is used there has to be `genom_middleware`.
#[macro_export]
macro_rules! portless {
    ($($middleware:ty),+ $(,)?) => {$(
        impl ::genom_middleware::Ports for $middleware {
            fn publisher(
                &self,
                port: &::genom_middleware::PortSpec<'_>,
            ) -> ::std::result::Result<
                ::std::boxed::Box<dyn ::genom_middleware::Publisher>,
                ::genom_middleware::OpenError,
            > {
                Err($crate::portless::refused(port))
            }

            fn subscription(
                &self,
                port: &::genom_middleware::PortSpec<'_>,
                _: ::genom_middleware::Policy,
            ) -> ::std::result::Result<
                ::std::boxed::Box<dyn ::genom_middleware::Subscription>,
                ::genom_middleware::OpenError,
            > {
                Err($crate::portless::refused(port))
            }
        }
    )+};
}

/// Why there is no port.
#[doc(hidden)]
#[must_use]
pub fn refused(port: &genom_middleware::PortSpec<'_>) -> genom_middleware::OpenError {
    genom_middleware::OpenError::Taken { address: port.address.clone() }
}
