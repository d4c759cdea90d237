//! Records of fixed layout, little-endian: header slots, directory entries, journals. In: fields.
//! Out: bytes, and back.

/// A number or byte string of fixed size, little-endian.
pub trait Plain: Sized {
    /// Adds the bytes of the value to `out`.
    fn put(&self, out: &mut Vec<u8>);
    /// Returns the value at the start of `bytes` and the bytes after it.
    fn take(bytes: &[u8]) -> Option<(Self, &[u8])>;
}

macro_rules! plain_numbers {
    ($($number:ty)*) => {$(
        impl Plain for $number {
            fn put(&self, out: &mut Vec<u8>) {
                out.extend_from_slice(&self.to_le_bytes());
            }
            fn take(bytes: &[u8]) -> Option<(Self, &[u8])> {
                bytes.split_first_chunk().map(|(head, rest)| (Self::from_le_bytes(*head), rest))
            }
        }
    )*};
}
plain_numbers!(u16 u32 u64);

impl<const N: usize> Plain for [u8; N] {
    fn put(&self, out: &mut Vec<u8>) {
        out.extend_from_slice(self);
    }
    fn take(bytes: &[u8]) -> Option<(Self, &[u8])> {
        bytes.split_first_chunk().map(|(head, rest)| (*head, rest))
    }
}

/// Declares a record of the file: its fields in file order, without gaps. A test compares `FIELDS`
/// with the format's text.
#[macro_export]
macro_rules! record {
    ($(#[$about:meta])* $name:ident { $($(#[$field_about:meta])* $field:ident: $kind:ty,)* }) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub struct $name { $($(#[$field_about])* pub $field: $kind,)* }

        impl $name {
            /// Name and size of every field, in file order.
            pub const FIELDS: &'static [(&'static str, usize)] = &[$((stringify!($field), size_of::<$kind>())),*];

            /// Adds the bytes of the record to `out`.
            pub fn put(&self, out: &mut Vec<u8>) {
                $($crate::archive::record::Plain::put(&self.$field, out);)*
            }

            /// Returns the record at the start of `bytes`, and the bytes after it.
            pub fn take(bytes: &[u8]) -> Option<(Self, &[u8])> {
                $(let ($field, bytes) = $crate::archive::record::Plain::take(bytes)?;)*
                Some(($name { $($field,)* }, bytes))
            }
        }
    };
}
