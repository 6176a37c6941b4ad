//! Does what a client's messages ask for.

use std::sync::Arc;

use foxglove::ws_protocol::client::{ClientMessage, Subscription};
use genom_doors::RpcError;
use genom_protocol::Right;

use crate::advertised::{AdvertiseError, ValueError};
use crate::client::{Client, SubscribeError};
use crate::hub::Hub;
use crate::lock::lock;
use crate::parameters::ParametersError;
use crate::{calls, parameters};

/// Why a message is not obeyed, as the client is told.
#[derive(Debug, thiserror::Error)]
pub(crate) enum OrderError {
    #[error("{}", .0.message())]
    Right(RpcError),
    #[error(transparent)]
    Subscribe(#[from] SubscribeError),
    #[error(transparent)]
    Advertise(#[from] AdvertiseError),
    #[error(transparent)]
    Value(#[from] ValueError),
    #[error(transparent)]
    Parameters(#[from] ParametersError),
    #[error("there are no assets here")]
    Assets,
    #[error("this is live, and cannot be played back")]
    Playback,
}

impl From<RpcError> for OrderError {
    fn from(error: RpcError) -> Self {
        Self::Right(error)
    }
}

/// Does all, and returns the first error of it.
fn first_error<E>(all: impl Iterator<Item = Result<(), E>>) -> Result<(), E> {
    all.fold(Ok(()), Result::and)
}

/// Does what a message asks for; what takes time goes on beside.
pub(crate) fn obey(
    hub: &Arc<Hub>,
    client: &Arc<Client>,
    message: ClientMessage<'_>,
) -> Result<(), OrderError> {
    match message {
        ClientMessage::Subscribe(asked) => {
            let all = asked.subscriptions.iter();
            let told = first_error(all.map(|one| subscribe(hub, client, one)));
            hub.subscriptions_changed();
            told?;
        }
        ClientMessage::Unsubscribe(asked) => {
            client.unsubscribe(&asked.subscription_ids.into_iter().collect());
            hub.subscriptions_changed();
        }
        ClientMessage::Advertise(asked) => {
            client.may(Right::Call, "publishing")?;
            first_error(asked.channels.iter().map(|one| client.channels.advertise(one)))?;
        }
        ClientMessage::Unadvertise(asked) => client.channels.unadvertise(&asked.channel_ids),
        ClientMessage::MessageData(sent) => client.channels.take(sent.channel_id, &sent.data)?,
        ClientMessage::ServiceCallRequest(asked) => calls::call(hub, client, &asked),
        ClientMessage::GetParameters(asked) => {
            client.may(Right::Call, "reading parameters")?;
            parameters::get(hub, client, asked)?;
        }
        ClientMessage::SetParameters(asked) => {
            client.may(Right::Call, "setting parameters")?;
            parameters::set(hub, client, asked)?;
        }
        ClientMessage::SubscribeParameterUpdates(asked) => {
            client.may(Right::Call, "reading parameters")?;
            parameters::subscribe(client, asked.parameter_names)?;
        }
        ClientMessage::UnsubscribeParameterUpdates(asked) => {
            let mut watched = lock(&client.parameters);
            asked.parameter_names.iter().for_each(|name| drop(watched.remove(name)));
        }
        ClientMessage::SubscribeConnectionGraph => {
            client.show_graph(true);
            hub.subscriptions_changed();
        }
        ClientMessage::UnsubscribeConnectionGraph => client.show_graph(false),
        ClientMessage::FetchAsset(_) => return Err(OrderError::Assets),
        ClientMessage::PlaybackControlRequest(_) => return Err(OrderError::Playback),
    }
    Ok(())
}

fn subscribe(hub: &Hub, client: &Client, one: &Subscription) -> Result<(), SubscribeError> {
    if !hub.has_channel(one.channel_id) {
        return Err(SubscribeError::Channel(one.channel_id));
    }
    client.subscribe(one)
}
