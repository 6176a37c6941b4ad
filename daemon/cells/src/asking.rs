//! Requests to a cell.

use genom_protocol::routes::{self, Route};
use genom_protocol::{CellState, Replayed};
use http_body_util::BodyExt as _;
use hyper::body::{Body, Bytes, Incoming};
use hyper::{Method, Request, Response};
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::cell::{Cell, Down};
use crate::client::AskError;

impl Cell {
    /// Passes a request on as it is, and its response back. Of a cell that is stopping, how its
    /// activities end can still be learnt.
    ///
    /// # Errors
    /// The cell is down, or its process ended before it had answered.
    pub async fn forward<B>(&self, request: Request<B>) -> Result<Response<Incoming>, Down>
    where
        B: Body + Send + Unpin + 'static,
        B::Data: Send,
        B::Error: Into<Box<dyn std::error::Error + Send + Sync>>,
    {
        if let Err(down) = self.answers().await {
            let still_tells = down.state == CellState::Stopping && request.method() == Method::GET;
            if !still_tells {
                return Err(down);
            }
        }
        match self.client().send(request).await {
            Ok(response) => Ok(response),
            Err(_) => Err(self.lost().await),
        }
    }

    /// Asks a route that takes no body.
    ///
    /// # Errors
    /// It does not answer, or refuses.
    pub async fn ask<R: DeserializeOwned, Q>(&self, route: &Route<R, Q>) -> Result<R, AskError> {
        self.client().ask(route).await
    }

    /// Asks a route with a body.
    ///
    /// # Errors
    /// It does not answer, or refuses.
    pub async fn tell<R: DeserializeOwned, Q, B: Serialize>(
        &self,
        route: &Route<R, Q, B>,
        body: &B,
    ) -> Result<R, AskError> {
        self.client().tell(route, body).await
    }

    /// Publishes samples of a recording in the cell, as `POST /replay` takes them.
    ///
    /// # Errors
    /// It does not answer, or refuses.
    pub async fn publish(&self, samples: Bytes) -> Result<Replayed, AskError> {
        self.client().send_bytes(&routes::replay(), samples).await
    }

    /// Asks a route that answers with a text.
    ///
    /// # Errors
    /// It does not answer, or refuses.
    pub async fn text(&self, route: &Route<routes::Bytes>) -> Result<String, AskError> {
        self.answers().await.map_err(|down| AskError::Gone(down.to_string()))?;
        let body = self.client().stream(route, &()).await?.into_body();
        let body = body.collect().await.map_err(|error| AskError::Gone(error.to_string()))?;
        Ok(String::from_utf8_lossy(&body.to_bytes()).into_owned())
    }

    /// Asks a route that answers with bytes, which come as they are made.
    ///
    /// # Errors
    /// It does not answer, or refuses.
    pub async fn stream<Q, B: Serialize>(
        &self,
        route: &Route<routes::Bytes, Q, B>,
        body: &B,
    ) -> Result<Response<Incoming>, AskError> {
        self.client().stream(route, body).await
    }
}
