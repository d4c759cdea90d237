//! `message!`. In: a text as `format!` takes it, which names fields and commands in double braces.
//! Out: the parts of a message.

use proc_macro2::TokenStream as Tokens;
use quote::quote;
use syn::parse::{Parse, ParseStream};
use syn::punctuated::Punctuated;
use syn::{Error, Expr, LitStr, Result, Token};

/// Text and arguments of `message!`.
pub struct Message {
    text: LitStr,
    args: Vec<Expr>,
}

impl Parse for Message {
    fn parse(input: ParseStream) -> Result<Self> {
        let text = input.parse()?;
        if input.is_empty() {
            return Ok(Message { text, args: Vec::new() });
        }
        input.parse::<Token![,]>()?;
        let args = Punctuated::<Expr, Token![,]>::parse_terminated(input)?;
        Ok(Message { text, args: args.into_iter().collect() })
    }
}

impl Message {
    /// Returns an expression that makes the message.
    pub fn expand(&self) -> Result<Tokens> {
        let text = self.text.value();
        let mut args = self.args.iter();
        let (mut pieces, mut part, mut taken, mut rest) = (Vec::new(), String::new(), Vec::new(), text.as_str());
        let texts = |part: &mut String, taken: &mut Vec<&Expr>, pieces: &mut Vec<Tokens>| {
            if !part.is_empty() {
                let (text, args) = (LitStr::new(part, self.text.span()), taken.drain(..));
                pieces.push(quote!(::heliotile_requests::Piece::Text(::std::format!(#text #(, #args)*).into())));
                part.clear();
            }
        };
        while let Some(open) = rest.find('{') {
            part += &rest[..open];
            rest = &rest[open..];
            if let Some((name, behind)) = name_of(rest) {
                texts(&mut part, &mut taken, &mut pieces);
                pieces.push(match name.strip_prefix("command:") {
                    Some(command) => quote!(::heliotile_requests::Piece::Command(#command)),
                    None => quote!(::heliotile_requests::Piece::Field(#name)),
                });
                rest = behind;
                continue;
            }
            if let Some(behind) = rest.strip_prefix("{{") {
                part += "{{";
                rest = behind;
                continue;
            }
            let close = rest.find('}').ok_or_else(|| Error::new(self.text.span(), "a brace has no end"))?;
            let slot = &rest[..=close];
            if slot.starts_with("{}") || slot.starts_with("{:") {
                taken.push(args.next().ok_or_else(|| Error::new(self.text.span(), "an argument is missing"))?);
            }
            part += slot;
            rest = &rest[close + 1..];
        }
        part += rest;
        texts(&mut part, &mut taken, &mut pieces);
        match args.next() {
            Some(left) => Err(Error::new_spanned(left, "is an argument without braces")),
            None => Ok(quote!(::heliotile_requests::Message::new([#(#pieces),*]))),
        }
    }
}

/// Returns the name in double braces at the start of a text, and what follows.
fn name_of(text: &str) -> Option<(&str, &str)> {
    let (name, behind) = text.strip_prefix("{{")?.split_once("}}")?;
    let (words, other) = name.strip_prefix("command:").map_or((name, &b"_"[..]), |words| (words, b" -"));
    let is_name = !words.is_empty() && words.bytes().all(|byte| byte.is_ascii_lowercase() || other.contains(&byte));
    is_name.then_some((name, behind))
}
