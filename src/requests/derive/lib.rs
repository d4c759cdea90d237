//! `#[derive(Request)]`. In: a struct whose fields have a doc comment and an attribute `field`.
//! Out: its rows, how texts fill its fields, and the files that it names.

#![deny(missing_docs)]

mod message;

use proc_macro::TokenStream;
use proc_macro2::TokenStream as Tokens;
use quote::{format_ident, quote};
use syn::meta::ParseNestedMeta;
use syn::punctuated::Punctuated;
use syn::{
    Attribute, Data, DeriveInput, Error, Expr, ExprLit, Field, GenericArgument, Lit, LitChar, LitStr, Meta, Path,
    PathArguments, Result, Token, Type, parenthesized, parse_macro_input,
};

/// Units that names of fields end with; faces leave them out.
const UNITS: [&str; 7] = ["_w_m2_sr", "_w_m2", "_percent", "_deg", "_m2", "_m", "_c"];

/// Implements `heliotile_requests::Request`. At a field, `field(...)` takes:
///
/// | key | meaning |
/// | --- | --- |
/// | `flatten`, `heading = ".."`, `without(..)` | the field is a request itself; heading of its options; fields that are left out |
/// | `ungrouped` | the groups of that request do not count |
/// | `defaults("name", "text", ..)`, `needs(..)` | other defaults of its fields; fields, one of which must be filled with any of its own |
/// | `skip` | no face fills the field |
/// | `name = ".."` | name in faces; default: that of the field without its unit |
/// | `python = ".."`, `short = 'w'`, `metavar = ".."`, `positional` | name in Python; short option; placeholder; an argument without an option |
/// | `input = Kind`, `output = Kind`, `neutral` | a file that is read or written; a field that changes no values |
/// | `default = ".."`, `required` | text of the default, or the default itself if it is no text; no default |
/// | `negated = "no_scene"` | option that makes a field false whose default is true |
/// | `delimiter = ','`, `several`, `hyphen` | separator of values; several values behind one option; values may begin with `-` |
/// | `requires(..)`, `conflicts(..)` | names of other fields |
/// | `help = f`, `parse = f`, `choices = f` | functions in place of the doc comment and of the type's reader and names |
/// | `range = a..=b`, `says = ".."` | range of a number; what a wrong text is answered |
///
/// At the struct, `request(exactly_one(..))`, `request(at_most_one(..))` and `request(any_of(..))`
/// name groups of fields, `request(also = f)` a function that hands on files that no field states,
/// and `request(skips = f)` one that names fields whose files are others than their kind says.
#[proc_macro_derive(Request, attributes(field, request))]
pub fn derive(input: TokenStream) -> TokenStream {
    let input = parse_macro_input!(input as DeriveInput);
    expand(&input).unwrap_or_else(Error::into_compile_error).into()
}

/// Implements `Default` for a request: each field that states a default has it, a flag that is
/// `negated` is true, and any other field has the default of its type. A test of each command
/// compares the texts of defaults with the values.
#[proc_macro_derive(DefaultRequest, attributes(field, request))]
pub fn derive_default(input: TokenStream) -> TokenStream {
    let input = parse_macro_input!(input as DeriveInput);
    expand_default(&input).unwrap_or_else(Error::into_compile_error).into()
}

/// Makes a message of a text as `format!` takes it, which names fields of requests and commands in
/// double braces: `message!("{file}: give {{every}} month, or run {{command:archive verify}}")`.
#[proc_macro]
pub fn message(input: TokenStream) -> TokenStream {
    let message = parse_macro_input!(input as message::Message);
    message.expand().unwrap_or_else(Error::into_compile_error).into()
}

fn expand(input: &DeriveInput) -> Result<Tokens> {
    let Data::Struct(data) = &input.data else {
        return Err(Error::new_spanned(&input.ident, "a request is a struct with named fields"));
    };
    let about = About::new(&input.attrs)?;
    let (mut rows, mut groups, mut fill, mut files) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let mut ranges = Vec::new();
    for field in &data.fields {
        let (Some(ident), of) = (&field.ident, FieldAttribute::new(field)?) else { continue };
        if of.skip {
            continue;
        }
        let ty = &field.ty;
        if of.flatten {
            let (heading, without) = (option(&of.heading), &of.without);
            let (defaults, needs) = (of.defaults.chunks_exact(2).map(|pair| quote!((#(#pair),*))), &of.needs);
            rows.push(quote! {
                rows.extend(::heliotile_requests::under::<#ty>(::heliotile_requests::Under {
                    heading: #heading, without: &[#(#without),*], defaults: &[#(#defaults),*], needs: &[#(#needs),*],
                }));
            });
            if !of.ungrouped {
                groups.push(quote!(groups.extend(::heliotile_requests::groups_under::<#ty>(&[#(#without),*]));));
            }
            let known = (!without.is_empty()).then(|| quote!(![#(#without),*].contains(&name) &&)).into_iter();
            fill.push(quote! {
                if #(#known)* ::heliotile_requests::Request::fill(&mut self.#ident, name, texts)? { return Ok(true) }
            });
            files.push(quote!(::heliotile_requests::Request::files(&self.#ident, each);));
            ranges.push(quote!(::heliotile_requests::Request::in_range(&self.#ident)?;));
            continue;
        }
        let name = of.face_name(&ident.to_string());
        let (many, one) = shape(ty);
        rows.push(of.row(field, &name, many, one)?);
        let read = of.read(one);
        let taken = match (many, &of.negated) {
            (Many::Flag, negated) => {
                let stands = negated.is_none();
                quote!(self.#ident = ::heliotile_requests::flag(texts)? == #stands;)
            }
            (Many::One, _) => quote!(self.#ident = (#read)(::heliotile_requests::last(texts)?)?;),
            (Many::Optional, _) => quote!(self.#ident = Some((#read)(::heliotile_requests::last(texts)?)?);),
            (Many::List, _) => {
                quote!(self.#ident = texts.iter().map(|text| (#read)(text)).collect::<::std::result::Result<_, ::heliotile_requests::Wrong>>()?;)
            }
        };
        fill.push(quote!(if name == #name { #taken return Ok(true) }));
        if let Some(range) = &of.range {
            let says = option(&of.says);
            let each = if many == Many::One { quote!([&self.#ident]) } else { quote!(self.#ident.iter()) };
            ranges.push(quote! {
                for number in #each {
                    let text = number.to_string();
                    ::heliotile_requests::within(Ok(*number), &text, #range, #says).map_err(|wrong| wrong.in_field(#name))?;
                }
            });
        }
        if let Some(role) = &of.file {
            let each = match many {
                Many::One => quote!(::std::iter::once(&self.#ident)),
                _ => quote!(self.#ident.iter()),
            };
            files.push(quote! {
                #each
                    .filter_map(::heliotile_requests::Parse::path)
                    .filter(|path| !path.as_os_str().is_empty())
                    .for_each(|path| each(#name, #role, path));
            });
        }
    }
    let (ident, own) = (&input.ident, &about.groups);
    let (also, skips) = (about.also.iter(), about.skips.iter());
    let (generics, types, bounds) = input.generics.split_for_impl();
    Ok(quote! {
        impl #generics ::heliotile_requests::Request for #ident #types #bounds {
            fn rows() -> Vec<::heliotile_requests::Row> {
                let mut rows = Vec::new();
                #(#rows)*
                rows
            }
            fn groups() -> Vec<::heliotile_requests::Group> {
                let mut groups = vec![#(#own),*];
                #(#groups)*
                groups
            }
            fn fill(&mut self, name: &str, texts: &[String]) -> ::std::result::Result<bool, ::heliotile_requests::Wrong> {
                #(#fill)*
                Ok(false)
            }
            fn in_range(&self) -> ::std::result::Result<(), ::heliotile_requests::Refused> {
                #(#ranges)*
                Ok(())
            }
            fn files(&self, each: &mut dyn FnMut(&'static str, ::heliotile_requests::Role, &::std::path::Path)) {
                #(#files)*
                #(#also(self, each);)*
            }
            #(fn skips(&self) -> Vec<&'static str> { #skips(self) })*
        }
    })
}

fn expand_default(input: &DeriveInput) -> Result<Tokens> {
    let Data::Struct(data) = &input.data else {
        return Err(Error::new_spanned(&input.ident, "a request is a struct with named fields"));
    };
    let mut values = Vec::new();
    for field in &data.fields {
        let (Some(ident), of) = (&field.ident, FieldAttribute::new(field)?) else { continue };
        let value = of.default_value(&field.ty);
        values.push(quote!(#ident: #value));
    }
    let ident = &input.ident;
    Ok(quote! {
        impl ::std::default::Default for #ident {
            fn default() -> Self {
                #ident { #(#values),* }
            }
        }
    })
}

/// Number of values of a field.
#[derive(Clone, Copy, PartialEq)]
enum Many {
    One,
    Optional,
    List,
    Flag,
}

/// Returns how many values a type holds, and the type of one.
fn shape(ty: &Type) -> (Many, &Type) {
    let Type::Path(path) = ty else { return (Many::One, ty) };
    let Some(last) = path.path.segments.last() else { return (Many::One, ty) };
    let inner = match &last.arguments {
        PathArguments::AngleBracketed(all) => all.args.iter().find_map(|arg| match arg {
            GenericArgument::Type(inner) => Some(inner),
            _ => None,
        }),
        _ => None,
    };
    match (last.ident.to_string().as_str(), inner) {
        ("Option", Some(inner)) => (Many::Optional, inner),
        ("Vec", Some(inner)) => (Many::List, inner),
        ("bool", _) => (Many::Flag, ty),
        _ => (Many::One, ty),
    }
}

/// Contents of `request(..)` at a struct.
#[derive(Default)]
struct About {
    groups: Vec<Tokens>,
    also: Option<Path>,
    skips: Option<Path>,
}

impl About {
    fn new(attrs: &[Attribute]) -> Result<Self> {
        let mut found = About::default();
        for attr in attrs.iter().filter(|attr| attr.path().is_ident("request")) {
            attr.parse_nested_meta(|meta| {
                let key = meta.path.require_ident()?.to_string();
                let kind = match key.as_str() {
                    "exactly_one" => format_ident!("ExactlyOne"),
                    "at_most_one" => format_ident!("AtMostOne"),
                    "any_of" => format_ident!("AnyOf"),
                    "also" => {
                        found.also = Some(meta.value()?.parse()?);
                        return Ok(());
                    }
                    "skips" => {
                        found.skips = Some(meta.value()?.parse()?);
                        return Ok(());
                    }
                    _ => return Err(meta.error("unknown: exactly_one, at_most_one, any_of, also, skips")),
                };
                let names = names(&meta)?;
                found.groups.push(quote!(::heliotile_requests::Group { kind: ::heliotile_requests::GroupKind::#kind, names: &[#(#names),*] }));
                Ok(())
            })?;
        }
        Ok(found)
    }
}

/// Returns the texts in parentheses.
fn names(meta: &ParseNestedMeta) -> Result<Vec<LitStr>> {
    let inside;
    parenthesized!(inside in meta.input);
    Ok(Punctuated::<LitStr, Token![,]>::parse_terminated(&inside)?.into_iter().collect())
}

/// Contents of `field(..)`.
#[derive(Default)]
struct FieldAttribute {
    flatten: bool,
    ungrouped: bool,
    skip: bool,
    without: Vec<LitStr>,
    defaults: Vec<LitStr>,
    needs: Vec<LitStr>,
    heading: Option<LitStr>,
    name: Option<LitStr>,
    python: Option<LitStr>,
    short: Option<LitChar>,
    metavar: Option<LitStr>,
    positional: bool,
    file: Option<Tokens>,
    neutral: bool,
    default: Option<Expr>,
    required: bool,
    negated: Option<LitStr>,
    delimiter: Option<LitChar>,
    several: bool,
    hyphen: bool,
    requires: Vec<LitStr>,
    conflicts: Vec<LitStr>,
    help: Option<Path>,
    parse: Option<Path>,
    choices: Option<Path>,
    range: Option<Expr>,
    says: Option<LitStr>,
}

impl FieldAttribute {
    fn new(field: &Field) -> Result<Self> {
        let mut found = FieldAttribute::default();
        for attr in field.attrs.iter().filter(|attr| attr.path().is_ident("field")) {
            attr.parse_nested_meta(|meta| found.take(&meta))?;
        }
        Ok(found)
    }

    fn take(&mut self, meta: &ParseNestedMeta) -> Result<()> {
        let key = meta.path.require_ident()?.to_string();
        match key.as_str() {
            "flatten" => self.flatten = true,
            "ungrouped" => self.ungrouped = true,
            "skip" => self.skip = true,
            "positional" => self.positional = true,
            "neutral" => self.neutral = true,
            "required" => self.required = true,
            "several" => self.several = true,
            "hyphen" => self.hyphen = true,
            "heading" => self.heading = Some(meta.value()?.parse()?),
            "name" => self.name = Some(meta.value()?.parse()?),
            "python" => self.python = Some(meta.value()?.parse()?),
            "short" => self.short = Some(meta.value()?.parse()?),
            "metavar" => self.metavar = Some(meta.value()?.parse()?),
            "default" => self.default = Some(meta.value()?.parse()?),
            "negated" => self.negated = Some(meta.value()?.parse()?),
            "delimiter" => self.delimiter = Some(meta.value()?.parse()?),
            "help" => self.help = Some(meta.value()?.parse()?),
            "choices" => self.choices = Some(meta.value()?.parse()?),
            "without" => self.without = names(meta)?,
            "defaults" => self.defaults = names(meta)?,
            "needs" => self.needs = names(meta)?,
            "parse" => self.parse = Some(meta.value()?.parse()?),
            "range" => self.range = Some(meta.value()?.parse()?),
            "says" => self.says = Some(meta.value()?.parse()?),
            "requires" => self.requires = names(meta)?,
            "conflicts" => self.conflicts = names(meta)?,
            "input" => {
                let kind: Path = meta.value()?.parse()?;
                self.file = Some(quote!(::heliotile_requests::Role::Input(::heliotile_requests::InputKind::#kind)));
            }
            "output" => {
                let kind: Expr = meta.value()?.parse()?;
                self.file = Some(quote!(::heliotile_requests::Role::Output({
                    use ::heliotile_requests::OutputKind::*;
                    #kind
                })));
            }
            _ => return Err(meta.error("is not known: see the derive's table of keys")),
        }
        Ok(())
    }

    /// Returns the name in faces.
    fn face_name(&self, ident: &str) -> String {
        let stated = self.negated.as_ref().or(self.name.as_ref()).map(LitStr::value);
        let ident = ident.trim_start_matches("r#");
        let bare = || UNITS.iter().find_map(|unit| ident.strip_suffix(unit)).unwrap_or(ident).to_owned();
        stated.unwrap_or_else(bare)
    }

    /// Returns the function that reads one value.
    fn read(&self, one: &Type) -> Tokens {
        let parse = match &self.parse {
            Some(parse) => quote!(|text: &str| (#parse)(text).map_err(::heliotile_requests::Wrong::from)),
            None => quote!(<#one as ::heliotile_requests::Parse>::parse),
        };
        let read = match (&self.range, &self.says) {
            (Some(range), says) => {
                let says = option(says);
                quote!(::heliotile_requests::within((#parse)(text), text, #range, #says))
            }
            (None, Some(says)) => quote!((#parse)(text).map_err(|_| ::heliotile_requests::Wrong::from(#says))),
            (None, None) => quote!((#parse)(text)),
        };
        quote!(|text: &str| #read.map_err(|wrong| wrong.found(text)))
    }

    /// Returns the value of a field of which nothing is given.
    fn default_value(&self, ty: &Type) -> Tokens {
        let (many, one) = shape(ty);
        let (read, delimiter) = (self.read(one), self.delimiter.iter());
        let other = self.defaults.chunks_exact(2).map(|pair| quote!((#(#pair),*)));
        match (&self.default, many) {
            (Some(Expr::Lit(ExprLit { lit: Lit::Str(text), .. })), Many::One) => {
                quote!((#read)(#text).unwrap_or_default())
            }
            (Some(text), Many::List) => quote!(#text #(.split(#delimiter))*.flat_map(#read).collect()),
            (Some(value), Many::One) => quote!(#value),
            (None, Many::Flag) if self.negated.is_some() => quote!(true),
            _ if !self.defaults.is_empty() => quote! {{
                let mut inside = #ty::default();
                for (name, text) in [#(#other),*] {
                    // The text is a constant, and a test fills it in.
                    let _ = ::heliotile_requests::Request::fill(&mut inside, name, &[text.to_owned()]);
                }
                inside
            }},
            _ => quote!(::std::default::Default::default()),
        }
    }

    fn row(&self, field: &Field, name: &str, many: Many, one: &Type) -> Result<Tokens> {
        let help = match &self.help {
            Some(help) => quote!(#help().into()),
            None => {
                let doc = doc_of(&field.attrs);
                if doc.is_empty() {
                    return Err(Error::new_spanned(field, "a field of a request needs a doc comment: it is the help"));
                }
                quote!(#doc.into())
            }
        };
        let role = match (&self.file, self.neutral) {
            (Some(role), _) => role.clone(),
            (None, true) => quote!(::heliotile_requests::Role::Neutral),
            (None, false) => quote!(::heliotile_requests::Role::Value),
        };
        let FieldAttribute { positional, required, several, hyphen, requires, conflicts, .. } = self;
        let [short, delimiter] = [&self.short, &self.delimiter].map(option);
        let [python, metavar] = [&self.python, &self.metavar].map(option);
        let default = match &self.default {
            Some(text) => quote!(Some(#text.to_string())),
            None => quote!(None),
        };
        let (kind, negated) = (format_ident!("{}", many.name()), self.negated.is_some());
        let (form, test) = match many {
            Many::Flag => (quote!(::heliotile_requests::Form::FLAG), quote!(|_| Ok(()))),
            _ => {
                let read = self.read(one);
                let form = match &self.choices {
                    Some(choices) => {
                        quote!(::heliotile_requests::Form { choices: #choices, ..<#one as ::heliotile_requests::Parse>::form() })
                    }
                    None => quote!(<#one as ::heliotile_requests::Parse>::form()),
                };
                let test = quote!(|text| {
                    let read: ::std::result::Result<#one, ::heliotile_requests::Wrong> = (#read)(text);
                    read.map(drop)
                });
                (form, test)
            }
        };
        Ok(quote! {
            rows.push(::heliotile_requests::Row {
                name: #name, python: #python, short: #short, metavar: #metavar, help: #help, heading: None, role: #role,
                form: #form, many: ::heliotile_requests::Many::#kind, default: #default, required: #required,
                positional: #positional, negated: #negated, delimiter: #delimiter, several: #several, hyphen: #hyphen,
                requires: &[#(#requires),*], conflicts: &[#(#conflicts),*], test: #test,
            });
        })
    }
}

impl Many {
    fn name(self) -> &'static str {
        match self {
            Many::One => "One",
            Many::Optional => "Optional",
            Many::List => "List",
            Many::Flag => "Flag",
        }
    }
}

fn option<T: quote::ToTokens>(value: &Option<T>) -> Tokens {
    value.as_ref().map_or(quote!(None), |value| quote!(Some(#value)))
}

/// Returns a doc comment as one paragraph without its last full stop.
fn doc_of(attrs: &[Attribute]) -> String {
    let line = |attr: &Attribute| match &attr.meta {
        Meta::NameValue(pair) if pair.path.is_ident("doc") => match &pair.value {
            Expr::Lit(ExprLit { lit: Lit::Str(text), .. }) => Some(text.value().trim().to_owned()),
            _ => None,
        },
        _ => None,
    };
    let lines: Vec<String> = attrs.iter().filter_map(line).collect();
    lines.join(" ").trim_end_matches('.').to_owned()
}
