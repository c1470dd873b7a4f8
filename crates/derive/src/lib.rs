//! Derives `Options` of `gfmd-problem`: the defaults of a group of options, the kinds of their numbers, and the options
//! that are arrays.
//!
//! A field is an option. Its clap attribute already has its flag and its default, and its doc comment is the help;
//! `#[option(kinds = Kinds::STRESS)]` adds the kind of its numbers, and
//! `#[option(array)]` says that it may be an array in memory:
//!
//! ```ignore
//! #[derive(clap::Args, Options)]
//! struct BodyArgs {
//!     /// Young's modulus
//!     #[arg(long, value_name = "E", default_value_t = 1.0)]
//!     #[option(kinds = Kinds::STRESS)]
//!     young: f64,
//!     #[command(flatten)]
//!     others: OtherArgs,
//! }
//! ```
//!
//! The default of a field is `default_value`, `default_value_t` or `default_values_t` of its clap attribute, else
//! `#[option(default = ..)]`, else the default of its type.

use proc_macro2::TokenStream;
use quote::quote;
use syn::parse::ParseStream;
use syn::{Data, DeriveInput, Error, Expr, Field, Fields, Token, parse_macro_input, parse_quote};

/// Derives `gfmd_problem::options::Options` and `Default` for a struct of options.
#[proc_macro_derive(Options, attributes(option))]
pub fn derive_options(input: proc_macro::TokenStream) -> proc_macro::TokenStream {
    let input = parse_macro_input!(input as DeriveInput);
    expand(&input).unwrap_or_else(|error| error.to_compile_error()).into()
}

/// Default, kinds and form of a field, from its attributes.
#[derive(Default)]
struct Described {
    default: Option<Expr>,
    kinds: Option<Expr>,
    is_group: bool,
    is_array: bool,
}

impl Described {
    fn of(field: &Field) -> Result<Self, Error> {
        let mut described = Self::default();
        for attribute in &field.attrs {
            let path = attribute.path();
            if path.is_ident("command") {
                attribute.parse_nested_meta(|meta| {
                    described.is_group |= meta.path.is_ident("flatten");
                    skip(meta.input)
                })?;
            } else if path.is_ident("arg") || path.is_ident("option") {
                let of_clap = path.is_ident("arg");
                attribute.parse_nested_meta(|meta| {
                    if !of_clap && meta.path.is_ident("array") {
                        described.is_array = true;
                        return Ok(());
                    }
                    let place = match meta.path.get_ident().map(ToString::to_string).as_deref() {
                        Some("default_value_t") if of_clap => &mut described.default,
                        Some("default_values_t") if of_clap => {
                            let values: Expr = meta.value()?.parse()?;
                            described.default = Some(parse_quote!((#values).into_iter().collect()));
                            return Ok(());
                        }
                        Some("default_value") if of_clap => {
                            let text: Expr = meta.value()?.parse()?;
                            described.default = Some(parse_quote!(::std::convert::Into::into(#text)));
                            return Ok(());
                        }
                        Some("default") if !of_clap => &mut described.default,
                        Some("kinds") if !of_clap => &mut described.kinds,
                        Some(_) if of_clap => return skip(meta.input),
                        _ => return Err(meta.error("it must be kinds, default or array")),
                    };
                    *place = Some(meta.value()?.parse()?);
                    Ok(())
                })?;
            }
        }
        Ok(described)
    }
}

/// Passes over the value of an attribute that says nothing here.
fn skip(input: ParseStream) -> Result<(), Error> {
    if input.peek(Token![=]) {
        input.parse::<Token![=]>()?;
        input.parse::<Expr>()?;
    } else if input.peek(syn::token::Paren) {
        let inside;
        syn::parenthesized!(inside in input);
        inside.parse::<TokenStream>()?;
    }
    Ok(())
}

fn expand(input: &DeriveInput) -> Result<TokenStream, Error> {
    let Data::Struct(data) = &input.data else { return Err(Error::new_spanned(&input.ident, "it must be a struct")) };
    let Fields::Named(fields) = &data.fields else {
        return Err(Error::new_spanned(&input.ident, "it must have named fields"));
    };
    let name = &input.ident;
    let (mut defaults, mut kinds, mut arrays) = (Vec::new(), Vec::new(), Vec::new());
    for field in &fields.named {
        let Described { default, kinds: of_field, is_group, is_array } = Described::of(field)?;
        let (ident, of) = (&field.ident, &field.ty);
        let default = default.map_or_else(|| quote!(::std::default::Default::default()), |default| quote!(#default));
        defaults.push(quote!(#ident: #default));
        if is_group {
            if let Some(of_field) = of_field {
                return Err(Error::new_spanned(of_field, "a group has the kinds of its own fields"));
            }
            kinds.push(quote!(<#of as ::gfmd_problem::options::Options>::kinds(see);));
            arrays.push(quote!(::gfmd_problem::options::Options::take_arrays(&mut self.#ident, arrays);));
        } else {
            kinds.extend(of_field.map(|of_field| quote!(see(stringify!(#ident), #of_field);)));
            if is_array {
                arrays.push(quote! {
                    if let Some(array) = arrays.remove(stringify!(#ident)) {
                        self.#ident = Some(array.into());
                    }
                });
            }
        }
    }
    Ok(quote! {
        impl ::std::default::Default for #name {
            fn default() -> Self {
                Self { #(#defaults),* }
            }
        }

        impl ::gfmd_problem::options::Options for #name {
            fn kinds(see: &mut dyn FnMut(&'static str, ::gfmd_problem::options::Kinds)) {
                #(#kinds)*
            }

            fn take_arrays(&mut self, arrays: &mut ::gfmd_problem::options::given::Arrays) {
                #(#arrays)*
            }
        }
    })
}
