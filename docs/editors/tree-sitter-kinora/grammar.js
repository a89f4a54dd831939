// The grammar for editors. The language's own is lang/src/grammar.pest; tests/tests/tree_sitter.rs holds this one against it.
//
// src/scanner.c reads what needs a look ahead: units, colours, and whether an item may end where the text is. An item
// ends before a new line, `,`, `;`, `}` and the end of the file; a new line that an operator or bracket follows ends none.

const KEYWORDS = [
  "after", "as", "ease", "else", "false", "fn", "for", "from", "if", "import", "in", "keys", "lang", "let", "like",
  "param", "prefab", "return", "true",
];

// What other languages write for `else if`. No keywords, but no kinds of nodes either.
const NO_KINDS = ["elif", "elseif", "elsf", "elsif"];

// Characters that a source may not hold: controls, and those that change the direction of writing.
const BARRED = "\\x00-\\x08\\x0e-\\x1f\\x7f-\\x9f\\u202a-\\u202e\\u2066-\\u2069";

/** Values with commas between them, and perhaps one behind the last. */
function list(rule) {
  return seq(rule, repeat(seq(",", rule)), optional(","));
}

/** The tightest first. */
const LEVEL = { postfix: 8, power: 7, unary: 6, times: 5, plus: 4, comparison: 3, and: 2, or: 1 };

export default grammar({
  name: "kinora",

  externals: $ => [$._end, $._param_end, $._import_end, $.unit, $._no_unit, $.color, $._glued, $._body_may_follow, $._error],

  word: $ => $.identifier,

  reserved: { global: _ => KEYWORDS },

  extras: $ => [/[ \t-\r]/, $.comment],

  supertypes: $ => [$._item, $._expression],

  inline: $ => [$._separator, $._name],

  rules: {
    source_file: $ => repeat(choice($._separator, $._item)),

    _separator: _ => choice(",", ";"),

    comment: _ => token(choice(
      new RegExp(`//[^\\n${BARRED}]*`),
      new RegExp(`/\\*([^*${BARRED}]|\\*+[^*/${BARRED}])*\\*+/`),
    )),

    // Items

    _item: $ => choice(
      $.property, $.node, $.lang, $.import, $.param, $.let, $.function, $.prefab, $.for, $.if, $.return,
    ),

    block: $ => seq("{", repeat(choice($._separator, $._item)), "}"),

    property: $ => seq(
      field("name", choice($._key, alias(choice(...NO_KINDS), $.identifier), $.string)), ":",
      field("value", $._value), $._end,
    ),

    // Before `:` a keyword is a name.
    _key: $ => choice($.identifier, alias(choice(...KEYWORDS), $.identifier)),

    node: $ => seq(
      field("kind", $.path),
      field("name", optional(choice($.identifier, $.string))),
      $._body,
    ),

    _body: $ => choice(field("body", $.block), $._like),
    _like: $ => seq("like", field("like", $._expression), field("body", $.block)),

    lang: $ => seq("lang", optional("-"), field("version", $.number), $._end),

    import: $ => seq(
      "import",
      optional(seq(field("names", $.import_names), "from")),
      field("file", $.string),
      choice($._import_end, seq("as", $._name, $._end)),
    ),
    import_names: $ => seq("{", optional(list($.import_name)), "}"),
    import_name: $ => seq(field("from", $.identifier), optional(seq("as", $._name))),
    _name: $ => field("name", $.identifier),

    param: $ => prec.right(seq(
      "param", $._name, optional($._of_type), "=",
      choice(
        seq(field("value", $._braced), optional($._of_range)),
        seq(field("value", $._expression), choice($._param_end, $._of_range)),
      ),
    )),
    _of_range: $ => seq("in", field("range", $._expression), $._end),

    let: $ => seq("let", $._name, optional($._of_type), $._is),

    // What ends in a brace needs nothing behind it.
    _is: $ => seq("=", choice(field("value", $._braced), seq(field("value", $._expression), $._end))),

    _of_type: $ => seq(":", field("type", $.type)),
    type: $ => seq($.identifier, optional(seq("<", $.type, ">"))),

    function: $ => seq(
      "fn", $._name, field("parameters", $.parameters),
      optional(seq("->", field("result", $.type))),
      choice(field("body", $.block), $._is),
    ),

    prefab: $ => seq(
      "prefab", $._name, field("parameters", optional($.parameters)), field("body", $.block),
    ),

    parameters: $ => seq("(", optional(list($.parameter)), ")"),
    parameter: $ => seq($._name, optional($._of_type), optional(seq("=", field("default", $._value)))),

    for: $ => seq("for", $._for_head, field("body", $.block)),
    _for_head: $ => seq(
      $._name, optional(seq(",", $._name)), "in", field("over", $._expression),
    ),

    if: $ => prec.right(seq(
      "if", field("condition", $._expression), field("then", $.block),
      repeat(seq("else", "if", field("condition", $._expression), field("then", $.block))),
      optional(seq("else", field("else", $.block))),
    )),

    return: $ => seq("return", choice(field("value", $._braced), seq(field("value", $._expression), $._end))),

    // Values: `{` is possible here and nowhere in an expression.

    _value: $ => choice($._braced, $._expression),

    _braced: $ => choice(alias($.node_value, $.node), $.keys, $.if_value),

    // The scanner never gives the last: that it would be valid tells it where `like` goes on.
    node_value: $ => seq(field("kind", $.path), choice($._body, $._body_may_follow)),

    if_value: $ => seq(
      "if", field("condition", $._expression), field("then", $.arm),
      repeat(seq("else", "if", field("condition", $._expression), field("then", $.arm))),
      "else", field("else", $.arm),
    ),
    arm: $ => seq("{", $._value, repeat($._separator), "}"),

    keys: $ => seq("keys", optional($.arguments), field("body", $.key_block)),
    key_block: $ => seq("{", repeat(choice($._separator, $.key)), "}"),
    key: $ => prec.right(seq(
      optional("after"), field("time", $._expression), ":", field("value", choice($.block, $._value)),
      optional(seq("ease", field("ease", $._expression))),
    )),

    // Expressions. Ranges and comparisons do not chain: neither has itself on a side.

    _expression: $ => choice($._or, alias($.range, $.binary)),
    range: $ => prec.right(LEVEL.or, operation($._or, "..", $._or)),

    _or: $ => choice($._and, alias($.or, $.binary)),
    or: $ => prec.left(LEVEL.or, operation($._or, "||", $._and)),

    _and: $ => choice($._compared, alias($.and, $.binary)),
    and: $ => prec.left(LEVEL.and, operation($._and, "&&", $._compared)),

    _compared: $ => choice($._sum, alias($.comparison, $.binary)),
    comparison: $ => prec.right(
      LEVEL.comparison, operation($._sum, choice("<", "<=", ">", ">=", "==", "!="), $._sum),
    ),

    _sum: $ => choice($._product, alias($.sum, $.binary)),
    sum: $ => prec.left(LEVEL.plus, operation($._sum, choice("+", "-"), $._product)),

    _product: $ => choice($._unary, alias($.product, $.binary)),
    product: $ => prec.left(LEVEL.times, operation($._product, choice("*", "/"), $._unary)),

    _unary: $ => choice($._power, $.unary),
    unary: $ => prec(LEVEL.unary, seq(field("operator", choice("-", "!")), $._unary)),

    _power: $ => choice($._operand, alias($.power, $.binary)),
    power: $ => prec.right(LEVEL.power, operation($._operand, "^", $._unary)),

    _operand: $ => choice($.number, $._postfixed),
    // No field of a number: `1.x`.
    _postfixed: $ => choice(
      $.path, $.tuple, $.list, $.string, $.color, $.boolean, $.call, $.index, $.field,
    ),

    call: $ => prec(LEVEL.postfix, seq(field("function", $._operand), $.arguments)),
    index: $ => prec(LEVEL.postfix, seq($._operand, "[", field("index", $._expression), "]")),
    field: $ => prec(LEVEL.postfix, seq($._postfixed, choice(".", token.immediate(".")), $._name)),

    arguments: $ => seq(
      "(",
      optional(choice(
        seq($._value, repeat(seq(",", $._value)), repeat(seq(",", $.argument)), optional(",")),
        list($.argument),
      )),
      ")",
    ),
    argument: $ => seq(field("name", $._key), ":", field("value", $._value)),

    tuple: $ => seq("(", optional(list($._value)), ")"),
    list: $ => seq("[", optional(choice(list($._value), seq($.comprehension, optional(",")))), "]"),
    comprehension: $ => seq(
      "for", $._for_head, optional(seq("if", field("condition", $._expression))), ":", field("value", $._value),
    ),

    // Tokens

    path: $ => prec.right(seq($.identifier, repeat(seq(token.immediate("."), $._glued, $.identifier)))),

    identifier: _ => /[\p{XID_Start}_]\p{XID_Continue}*/,

    boolean: _ => choice("true", "false"),

    number: $ => seq($._digits, choice($.unit, $._no_unit)),
    _digits: _ => /[0-9][0-9_]*(\.[0-9][0-9_]*)?([eE][+-]?[0-9][0-9_]*)?/,

    string: $ => seq(
      '"', repeat(choice($._text, $.escape)), token.immediate('"'),
    ),
    _text: _ => token.immediate(prec(1, new RegExp(`[^"\\\\\\n${BARRED}]+`))),
    escape: _ => token.immediate(seq("\\", choice(
      /["\\nt]/,
      // The codes of characters: up to 10FFFF without D800 to DFFF.
      seq("u{", choice(
        /[0-9a-fA-F]{1,3}/,
        /0{0,2}([0-9a-cA-Ce-fE-F][0-9a-fA-F]{3}|[dD][0-7][0-9a-fA-F]{2})/,
        /0?[1-9a-fA-F][0-9a-fA-F]{4}/,
        /10[0-9a-fA-F]{4}/,
      ), "}"),
    ))),
  },
});

function operation(left, operator, right) {
  return seq(field("left", left), field("operator", operator), field("right", right));
}
