//! Code as words and marks, from which names are read.

use proc_macro2::{Delimiter, Spacing, TokenTree};

use crate::source::{attribute, is_mark};

/// A word, a mark, or the tokens between brackets.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Token {
    /// A name or a keyword.
    Word(String),
    /// `::`
    PathMark,
    /// Any other mark; a literal is `"`.
    Mark(char),
    /// Tokens between brackets.
    Group { brace: bool, inside: Vec<Token> },
}

impl Token {
    /// The name, if it is a word.
    pub(super) fn word(&self) -> Option<&str> {
        match self {
            Token::Word(word) => Some(word),
            _ => None,
        }
    }

    /// True for this word.
    pub(super) fn is(&self, word: &str) -> bool {
        self.word() == Some(word)
    }
}

/// Tokens without attributes and lifetimes.
pub(super) fn tokens(trees: &[TokenTree]) -> Vec<Token> {
    let mut found = Vec::with_capacity(trees.len());
    let mut at = 0;
    while at < trees.len() {
        if let Some(attribute) = attribute(&trees[at..]) {
            at += attribute.length;
            continue;
        }
        let (token, length) = token(&trees[at..]);
        found.extend(token);
        at += length;
    }
    found
}

/// The first token, `None` for a lifetime, and the trees that it takes.
fn token(trees: &[TokenTree]) -> (Option<Token>, usize) {
    match &trees[0] {
        TokenTree::Ident(word) => (Some(Token::Word(word.to_string())), 1),
        TokenTree::Literal(_) => (Some(Token::Mark('"')), 1),
        TokenTree::Group(group) => {
            let inside: Vec<TokenTree> = group.stream().into_iter().collect();
            let brace = group.delimiter() == Delimiter::Brace;
            let inside = tokens(&inside);
            (Some(Token::Group { brace, inside }), 1)
        }
        TokenTree::Punct(mark) => match (mark.as_char(), mark.spacing()) {
            ('\'', _) => (None, 2),
            (':', Spacing::Joint) if trees.get(1).is_some_and(|next| is_mark(next, ':')) => {
                (Some(Token::PathMark), 2)
            }
            (mark, _) => (Some(Token::Mark(mark)), 1),
        },
    }
}
