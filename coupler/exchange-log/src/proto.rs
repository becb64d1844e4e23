//! The messages of the log in protobuf, and their description.

use prost::Message;
use prost_types::field_descriptor_proto::{Label, Type};
use prost_types::{
    DescriptorProto, FieldDescriptorProto, FieldOptions, FileDescriptorProto, FileDescriptorSet,
};

/// Full name of [`ExchangeMessage`].
pub const EXCHANGE: &str = "thirdbody.Exchange";

/// Full name of [`WindowEnd`].
pub const WINDOW_END: &str = "thirdbody.WindowEnd";

/// One frame, without its run id.
#[derive(Clone, PartialEq, Message)]
pub struct ExchangeMessage {
    /// Number of its [`protocol::Kind`].
    #[prost(uint32, tag = "1")]
    pub kind: u32,
    /// Version of the protocol.
    #[prost(uint32, tag = "2")]
    pub protocol: u32,
    /// Index of the interface in the scenario.
    #[prost(uint32, tag = "3")]
    pub interface: u32,
    /// Repeat of the window.
    #[prost(uint32, tag = "4")]
    pub iteration: u32,
    /// Coupling window.
    #[prost(uint64, tag = "5")]
    pub window: u64,
    /// Explicit steps since the start of the run at `t0_s`.
    #[prost(uint64, tag = "6")]
    pub step: u64,
    /// Explicit steps inside the window.
    #[prost(uint32, tag = "7")]
    pub substeps: u32,
    /// Start of the window (s).
    #[prost(double, tag = "8")]
    pub t0_s: f64,
    /// End of the window (s).
    #[prost(double, tag = "9")]
    pub t1_s: f64,
    /// Sender of the frame.
    #[prost(string, tag = "10")]
    pub sender: String,
    /// Receiver of the frame.
    #[prost(string, tag = "11")]
    pub receiver: String,
    /// The numbers; a text is packed as in [`protocol::frame::packed`].
    #[prost(double, repeated, tag = "12")]
    pub payload: Vec<f64>,
    /// XXH3 of the payload, from the frame.
    #[prost(fixed64, tag = "13")]
    pub checksum: u64,
}

/// Marks the end of a window: all its messages come before.
#[derive(Clone, PartialEq, Message)]
pub struct WindowEnd {
    /// The window.
    #[prost(uint64, tag = "1")]
    pub window: u64,
}

/// The description of both messages, an encoded `FileDescriptorSet`, written by hand to avoid a protobuf compiler. A test compares it with
/// the encoded messages.
pub fn descriptors() -> Vec<u8> {
    descriptor_set().encode_to_vec()
}

fn descriptor_set() -> FileDescriptorSet {
    let first: &[&str] = &["kind", "protocol", "interface", "iteration"];
    let exchange = [
        (Type::Uint32, first),
        (Type::Uint64, &["window", "step"]),
        (Type::Uint32, &["substeps"]),
        (Type::Double, &["t0_s", "t1_s"]),
        (Type::String, &["sender", "receiver"]),
        (Type::Double, &[PACKED]),
        (Type::Fixed64, &["checksum"]),
    ];
    let window_end = [(Type::Uint64, &["window"][..])];
    let messages = [("Exchange", &exchange[..]), ("WindowEnd", &window_end)];
    FileDescriptorSet {
        file: vec![FileDescriptorProto {
            name: Some("thirdbody/exchange.proto".into()),
            package: Some("thirdbody".into()),
            message_type: messages.map(|(name, fields)| message(name, fields)).into(),
            syntax: Some("proto3".into()),
            ..FileDescriptorProto::default()
        }],
    }
}

/// The only field that is a list.
const PACKED: &str = "payload";

/// A message with these fields, numbered from 1; each entry has the names of consecutive fields of one type.
fn message(name: &str, fields: &[(Type, &[&str])]) -> DescriptorProto {
    let all = fields.iter();
    let all = all.flat_map(|(kind, names)| names.iter().map(|name| (*kind, *name)));
    let numbered = (1..).zip(all);
    let fields = numbered.map(|(number, (kind, name))| field(number, name, kind));
    DescriptorProto {
        name: Some(name.into()),
        field: fields.collect(),
        ..DescriptorProto::default()
    }
}

fn field(number: i32, name: &str, kind: Type) -> FieldDescriptorProto {
    let list = name == PACKED;
    FieldDescriptorProto {
        name: Some(name.into()),
        json_name: Some(name.into()),
        number: Some(number),
        label: Some([Label::Optional, Label::Repeated][usize::from(list)].into()),
        r#type: Some(kind.into()),
        options: list.then(|| FieldOptions {
            packed: Some(true),
            ..FieldOptions::default()
        }),
        ..FieldDescriptorProto::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Number and wire type of each field in an encoded message.
    fn wire_fields(mut bytes: &[u8]) -> Vec<(i32, u64)> {
        let mut fields = Vec::new();
        while !bytes.is_empty() {
            let key = varint(&mut bytes);
            fields.push(((key >> 3) as i32, key & 7));
            match key & 7 {
                0 => drop(varint(&mut bytes)),
                1 => bytes = &bytes[8..],
                2 => {
                    let length = varint(&mut bytes) as usize;
                    bytes = &bytes[length..];
                }
                other => panic!("wire type {other} is not in use"),
            }
        }
        fields
    }

    fn varint(bytes: &mut &[u8]) -> u64 {
        prost::encoding::decode_varint(bytes).expect("it was just encoded")
    }

    fn described(name: &str) -> Vec<(i32, u64)> {
        let set = FileDescriptorSet::decode(descriptors().as_slice()).expect("just encoded");
        let message = set.file[0]
            .message_type
            .iter()
            .find(|message| message.name() == name)
            .expect("it is described");
        let wire = |field: &FieldDescriptorProto| match (field.label(), field.r#type()) {
            (Label::Repeated, _) | (_, Type::String) => 2,
            (_, Type::Double | Type::Fixed64) => 1,
            _ => 0,
        };
        let fields = message.field.iter();
        fields.map(|field| (field.number(), wire(field))).collect()
    }

    #[test]
    fn the_description_matches_the_encoded_messages() {
        let exchange = ExchangeMessage {
            kind: 1,
            protocol: 1,
            interface: 1,
            iteration: 1,
            window: 1,
            step: 1,
            substeps: 1,
            t0_s: 1.0,
            t1_s: 1.0,
            sender: "a".into(),
            receiver: "b".into(),
            payload: vec![1.0, 2.0],
            checksum: 1,
        };
        assert_eq!(
            wire_fields(&exchange.encode_to_vec()),
            described("Exchange")
        );
        let end = WindowEnd { window: 1 };
        assert_eq!(wire_fields(&end.encode_to_vec()), described("WindowEnd"));
    }
}
