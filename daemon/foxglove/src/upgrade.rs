//! Makes a WebSocket of a request.

use std::sync::Arc;

use axum::body::Body;
use axum::extract::{self, Request};
use axum::http::{self, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse as _, Response};
use genom_doors::{Peer, RpcError};
use genom_protocol::Code;
use hyper_util::rt::TokioIo;
use tokio_tungstenite::WebSocketStream;
use tokio_tungstenite::tungstenite::handshake::server::create_response;
use tokio_tungstenite::tungstenite::protocol::{Role, WebSocketConfig};

use crate::hub::Hub;
use crate::terms::Terms;
use crate::{gate, session};

/// The names that the protocol has had; clients offer one or several. Their messages are the same.
const PROTOCOLS: [&str; 2] = ["foxglove.sdk.v1", "foxglove.websocket.v1"];

#[derive(Clone)]
pub(crate) struct State {
    pub(crate) terms: Arc<Terms>,
    pub(crate) hub: Arc<Hub>,
}

/// Admits a client, or says why not.
pub(crate) async fn open(
    extract::State(State { terms, hub }): extract::State<State>,
    mut request: Request,
) -> Response {
    let visitor = match gate::admit(&terms, &request) {
        Ok(visitor) => visitor,
        Err(error) => return refuse(&terms, &request, error),
    };
    let response = match answer(&request) {
        Ok(response) => response,
        Err(error) => return refuse(&terms, &request, error),
    };
    let Some(seat) = terms.seat() else {
        let most = terms.section.max_clients;
        let message = format!("{most} clients are connected already");
        let error = RpcError::new(StatusCode::SERVICE_UNAVAILABLE, Code::TooManyStreams, message);
        let error = error.help("foxglove.max_clients of the configuration is the limit");
        return refuse(&terms, &request, error);
    };
    let upgrading = hyper::upgrade::on(&mut request);
    let peer = request.extensions().get::<Peer>().copied();
    // As long as they are there, the connection counts among those of the listener.
    let connection = request.extensions().clone();
    tokio::spawn(async move {
        match upgrading.await {
            Ok(upgraded) => {
                let longest = Some(terms.longest);
                let limits = WebSocketConfig::default()
                    .max_message_size(longest)
                    .max_frame_size(longest)
                    .write_buffer_size(0);
                let stream = TokioIo::new(upgraded);
                let socket = WebSocketStream::from_raw_socket(stream, Role::Server, Some(limits));
                session::serve(&terms, &hub, visitor, peer, socket.await).await;
            }
            Err(error) => tracing::debug!("foxglove: a client left early: {error}"),
        }
        drop((connection, seat));
    });
    response
}

fn refuse(terms: &Terms, request: &Request, error: RpcError) -> Response {
    terms.refuse(request, error.message());
    error.into_response()
}

/// The reply that agrees to a WebSocket and to the protocol.
fn answer(request: &Request) -> Result<Response, RpcError> {
    let offered = request.headers().get_all(header::SEC_WEBSOCKET_PROTOCOL).iter();
    let offered: Vec<_> =
        offered.filter_map(|all| all.to_str().ok()).flat_map(|all| all.split(',')).collect();
    let known = PROTOCOLS.iter().find(|known| offered.iter().any(|one| one.trim() == **known));
    let wrong = |message: String| {
        RpcError::new(StatusCode::BAD_REQUEST, Code::BadInput, message)
            .help("open this address as a \"Foxglove WebSocket\" connection in Foxglove")
    };
    let Some(protocol) = known else {
        return Err(wrong(format!("only clients of {} are served here", PROTOCOLS.join(" or "))));
    };
    let mut head = http::Request::new(());
    *head.method_mut() = request.method().clone();
    *head.version_mut() = request.version();
    *head.uri_mut() = request.uri().clone();
    head.headers_mut().clone_from(request.headers());
    let mut agreed =
        create_response(&head).map_err(|error| wrong(error.to_string()))?.map(|()| Body::empty());
    agreed.headers_mut().insert(header::SEC_WEBSOCKET_PROTOCOL, HeaderValue::from_static(protocol));
    Ok(agreed)
}
