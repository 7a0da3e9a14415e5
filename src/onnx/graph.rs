//! Nodes and tensors one after another, each with a name of its own.

use super::proto::{
    AttributeProto, AttributeType, DataType, Dimension, DimensionProto, GraphProto, NodeProto, TensorProto,
    TensorShapeProto, TensorTypeProto, TypeProto, ValueInfoProto,
};

/// A graph that is being written. Values are named by the node that makes them.
#[derive(Debug, Default)]
pub(crate) struct Graph {
    nodes: Vec<NodeProto>,
    tensors: Vec<TensorProto>,
}

/// A setting of a node.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Setting<'a> {
    Float(f32),
    Int(i64),
    Ints(&'a [i64]),
}

impl Graph {
    /// A node called `name` over `inputs`; the name of its one output, which is its own.
    pub(crate) fn node(
        &mut self,
        op: &str,
        name: impl Into<String>,
        inputs: &[&str],
        settings: &[(&str, Setting<'_>)],
    ) -> String {
        let name = name.into();
        let attribute = settings.iter().map(|(key, setting)| attribute(key, *setting)).collect();
        self.nodes.push(NodeProto {
            input: inputs.iter().map(|input| (*input).to_owned()).collect(),
            output: vec![name.clone()],
            name: Some(format!("{name}/{op}")),
            op_type: Some(op.to_owned()),
            attribute,
        });
        name
    }

    /// A constant tensor; its name.
    pub(crate) fn floats(&mut self, name: impl Into<String>, shape: &[usize], numbers: &[f32]) -> String {
        let bytes = numbers.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.tensor(name.into(), shape, DataType::Float, bytes)
    }

    /// A constant number; its name.
    pub(crate) fn float(&mut self, name: impl Into<String>, number: f32) -> String {
        self.floats(name, &[], &[number])
    }

    /// A list of whole numbers; its name.
    pub(crate) fn ints(&mut self, name: impl Into<String>, numbers: &[i64]) -> String {
        let bytes = numbers.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.tensor(name.into(), &[numbers.len()], DataType::Int64, bytes)
    }

    fn tensor(&mut self, name: String, shape: &[usize], of: DataType, bytes: Vec<u8>) -> String {
        self.tensors.push(TensorProto {
            dims: shape.iter().map(|n| *n as i64).collect(),
            data_type: Some(of as i32),
            name: Some(name.clone()),
            raw_data: Some(bytes),
        });
        name
    }

    /// The whole, with what goes in and comes out.
    pub(crate) fn finish(self, name: &str, input: ValueInfoProto, output: Vec<ValueInfoProto>) -> GraphProto {
        GraphProto {
            node: self.nodes,
            name: Some(name.to_owned()),
            initializer: self.tensors,
            input: vec![input],
            output,
        }
    }
}

/// A tensor of floats that goes in or comes out, its first size free.
pub(crate) fn value(name: &str, sizes: &[usize], doc: String) -> ValueInfoProto {
    let fixed = sizes.iter().map(|n| Dimension::Value(*n as i64));
    let dim = std::iter::once(Dimension::Param("batch".to_owned()))
        .chain(fixed)
        .map(|value| DimensionProto { value: Some(value) })
        .collect();
    let tensor =
        TensorTypeProto { elem_type: Some(DataType::Float as i32), shape: Some(TensorShapeProto { dim }) };
    ValueInfoProto {
        name: Some(name.to_owned()),
        r#type: Some(TypeProto { tensor_type: Some(tensor) }),
        doc_string: Some(doc),
    }
}

fn attribute(key: &str, setting: Setting<'_>) -> AttributeProto {
    let (f, i, ints, of) = match setting {
        Setting::Float(f) => (Some(f), None, Vec::new(), AttributeType::Float),
        Setting::Int(i) => (None, Some(i), Vec::new(), AttributeType::Int),
        Setting::Ints(ints) => (None, None, ints.to_vec(), AttributeType::Ints),
    };
    AttributeProto { name: Some(key.to_owned()), f, i, ints, r#type: Some(of as i32) }
}
