//! Messages of DDS as their bytes: whoever takes them decodes them.

use bytes::Bytes;
use rustdds::RepresentationIdentifier;
use rustdds::dds::adapters::no_key::{Decode, DefaultDecoder, DeserializerAdapter, SerializerAdapter};
use std::convert::Infallible;

/// What is taken: plain CDR of both versions and both orders of bytes.
const PLAIN: [RepresentationIdentifier; 4] = [
    RepresentationIdentifier::CDR_BE,
    RepresentationIdentifier::CDR_LE,
    RepresentationIdentifier::XCDR2_BE,
    RepresentationIdentifier::XCDR2_LE,
];

/// A message that came: its fields behind the four bytes that name their representation.
pub(crate) struct Came(pub(crate) Vec<u8>);

/// A message to be sent: its fields in plain CDR, the lowest byte first.
#[derive(Debug)]
pub(crate) struct Sent(pub(crate) Bytes);

/// Changes nothing.
pub(crate) struct AsBytes;

/// Puts the four bytes in front again, which DDS has taken off.
#[derive(Clone)]
pub(crate) struct WithRepresentation;

impl DeserializerAdapter<Came> for AsBytes {
    type Error = Infallible;
    type Decoded = Came;

    fn supported_encodings() -> &'static [RepresentationIdentifier] {
        &PLAIN
    }

    fn transform_decoded(decoded: Came) -> Came {
        decoded
    }
}

impl DefaultDecoder<Came> for AsBytes {
    type Decoder = WithRepresentation;
    const DECODER: WithRepresentation = WithRepresentation;
}

impl Decode<'_, Came> for WithRepresentation {
    type Error = Infallible;

    fn decode_bytes(self, fields: &[u8], encoding: RepresentationIdentifier) -> Result<Came, Infallible> {
        let known = [[0, 0], [0, 1], [0, 6], [0, 7]];
        let place = PLAIN.iter().position(|plain| *plain == encoding);
        // Others are not handed over; they would be named by whoever decodes.
        let representation = place.map_or([0xff, 0xff], |place| known[place]);
        Ok(Came([&representation[..], &[0, 0], fields].concat()))
    }
}

impl SerializerAdapter<Sent> for AsBytes {
    type Error = Infallible;

    fn output_encoding() -> RepresentationIdentifier {
        RepresentationIdentifier::CDR_LE
    }

    fn to_bytes(sent: &Sent) -> Result<Bytes, Infallible> {
        Ok(sent.0.clone())
    }
}
