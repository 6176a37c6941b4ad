//! Values of ports as images.

use std::sync::Arc;

use axum::body::Body;
use axum::extract::{Path, State};
use axum::http::header;
use axum::response::{IntoResponse as _, Response};
use genom_doors::{Parameters, RpcError};
use genom_ports::PortKey;
use genom_protocol::ImageParameters;
use genom_supervisor::Supervisor;
use genom_supervisor::components::Hosted;
use genom_types::Record;

use crate::named::{find, key};
use crate::picture::{NoPicture, Picture, is_image, picture};

/// Width of an image in pixels, unless the client says otherwise, and the greatest.
const USUAL: u32 = 640;
const WIDEST: u32 = 4096;

/// Get the last value of a port as an image.
///
/// For values that have the members of a ROS 2 `sensor_msgs/Image` (rgb8, bgr8, rgba8, bgra8, mono8,
/// mono16) the reply is three bytes for each pixel, row by row, of `image-width` and `image-height`;
/// for those of a `CompressedImage` it is the JPEG or PNG itself. `image-sample` is the number of
/// the sample: with it as `seen` the reply is empty until there is another one.
#[utoipa::path(
    get,
    path = "/components/{component}/ports/{port}/image",
    tag = "ports",
    params(ImageParameters),
    responses(
        (status = 200, content_type = "application/octet-stream", body = Vec<u8>),
        (status = 404),
        (status = 422)
    )
)]
pub async fn image(
    State(supervisor): State<Arc<Supervisor>>,
    Path((component, port)): Path<(String, String)>,
    Parameters(parameters): Parameters<ImageParameters>,
) -> Result<Response, RpcError> {
    let hosted = find(&supervisor.components, &component)?;
    let key = key(&hosted, &port, parameters.element)?;
    let width = parameters.width.unwrap_or(USUAL);
    if !(1..=WIDEST).contains(&width) {
        let message = format!("width: from 1 to {WIDEST} pixels");
        return Err(RpcError::bad_input(message).place("width"));
    }
    let address = hosted.port_address(&key).to_string();
    let refused = |why: &NoPicture| RpcError::bad_input(format!("{address}: {why}"));
    if !hosted.port_type(key.port).is_some_and(is_image) {
        return Err(refused(&NoPicture::Type));
    }
    let sample = hosted.ties.gauge(&key).map_or(0, |gauge| gauge.counts().samples);
    if sample == 0 || parameters.seen == Some(sample) {
        return Ok(nothing());
    }
    let work = tokio::task::spawn_blocking(move || shown(&hosted, &key, width));
    let shown = work.await.map_err(|error| RpcError::internal(error.to_string()))?;
    let number = [("image-sample", sample.to_string())];
    match shown {
        None => Ok(nothing()),
        Some(Err(why)) => Err(refused(&why)),
        Some(Ok(Picture::Pixels { width, height, whole, rgb })) => {
            let sizes = [
                ("image-width", width.to_string()),
                ("image-height", height.to_string()),
                ("image-whole", format!("{}x{}", whole.0, whole.1)),
            ];
            let kind = [(header::CONTENT_TYPE, "application/octet-stream")];
            Ok((kind, number, sizes, Body::from(rgb)).into_response())
        }
        Some(Ok(Picture::Compressed { media, bytes })) => {
            Ok(([(header::CONTENT_TYPE, media)], number, Body::from(bytes)).into_response())
        }
    }
}

/// There is no newer image.
fn nothing() -> Response {
    ([(header::CONTENT_TYPE, "application/octet-stream")], Body::empty()).into_response()
}

/// The last value as an image; `None` before the first, or while no copy of large values was kept
/// because nobody had asked for one.
fn shown(hosted: &Hosted, key: &PortKey, width: u32) -> Option<Result<Picture, NoPicture>> {
    let (message, ty) = (hosted.port_message(key)?, hosted.port_type(key.port)?);
    let mut value = Record::new(ty);
    value.decode_message(&message).ok()?;
    Some(picture(&value, width))
}
