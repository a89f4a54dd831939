// What the generated lexer cannot tell: it looks no further than the token itself.

#include "tree_sitter/parser.h"

enum Token { END, PARAM_END, IMPORT_END, UNIT, NO_UNIT, COLOR, GLUED, BODY_MAY_FOLLOW, ERROR };

void *tree_sitter_kinora_external_scanner_create(void) { return NULL; }
void tree_sitter_kinora_external_scanner_destroy(void *payload) { (void)payload; }
unsigned tree_sitter_kinora_external_scanner_serialize(void *payload, char *buffer) {
  (void)payload, (void)buffer;
  return 0;
}
void tree_sitter_kinora_external_scanner_deserialize(void *payload, const char *buffer, unsigned length) {
  (void)payload, (void)buffer, (void)length;
}

static bool is_space(int32_t c) { return c == ' ' || (c >= '\t' && c <= '\r'); }
static bool is_digit(int32_t c) { return c >= '0' && c <= '9'; }
static bool is_letter(int32_t c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }
// Beyond ASCII every character counts as a letter: what is none is a mistake there anyway.
static bool starts_name(int32_t c) { return is_letter(c) || c == '_' || c >= 0x80; }
static bool goes_on(int32_t c) { return starts_name(c) || is_digit(c); }

static bool is_word(const char *text, const char *const *words, unsigned count) {
  for (unsigned i = 0; i < count; i++) {
    const char *a = text, *b = words[i];
    while (*a && *a == *b) a++, b++;
    if (*a == *b) return true;
  }
  return false;
}

// Reads a word into a buffer; one that is too long is cut, and matches none.
static void read_word(TSLexer *lexer, char word[8]) {
  unsigned length = 0;
  while (!lexer->eof(lexer) && goes_on(lexer->lookahead)) {
    if (length < 7) word[length++] = lexer->lookahead < 0x80 ? (char)lexer->lookahead : '?';
    lexer->advance(lexer, false);
  }
  word[length] = 0;
}

// `m`, `s^2`
static bool unit_term(TSLexer *lexer) {
  static const char *const WORDS[] = {"mm", "ms", "min", "m",  "cm",   "cd", "km", "kg", "deg", "sr", "s",  "rad",
                                      "turn", "ft", "f", "in", "Hz", "K",  "W",  "N",  "J",  "g",  "lm", "lx"};
  char word[8];
  read_word(lexer, word);
  return is_word(word, WORDS, sizeof WORDS / sizeof *WORDS);
}

static void power(TSLexer *lexer) {
  if (lexer->lookahead != '^') return;
  lexer->advance(lexer, false);
  if (lexer->lookahead == '-') lexer->advance(lexer, false);
  if (!is_digit(lexer->lookahead)) return;
  lexer->advance(lexer, false);
  lexer->mark_end(lexer);
}

// Behind a number: a unit, or nothing that looks like one.
static bool unit(TSLexer *lexer) {
  lexer->mark_end(lexer);
  if (lexer->lookahead == '%' && !lexer->eof(lexer)) {
    lexer->advance(lexer, false);
    lexer->mark_end(lexer);
    lexer->result_symbol = UNIT;
    return true;
  }
  if (lexer->eof(lexer) || !starts_name(lexer->lookahead)) {
    lexer->result_symbol = NO_UNIT;
    return true;
  }
  if (!unit_term(lexer)) return false;
  lexer->mark_end(lexer);
  lexer->result_symbol = UNIT;
  power(lexer);
  // `3m/s` is a speed, `3m/steps` divides.
  while (lexer->lookahead == '/' || lexer->lookahead == '*') {
    lexer->advance(lexer, false);
    if (!is_letter(lexer->lookahead) || !unit_term(lexer)) break;
    lexer->mark_end(lexer);
    power(lexer);
  }
  return true;
}

static bool color(TSLexer *lexer) {
  while (is_space(lexer->lookahead)) lexer->advance(lexer, true);
  if (lexer->lookahead != '#') return false;
  lexer->advance(lexer, false);
  unsigned digits = 0;
  while (is_digit(lexer->lookahead) || (lexer->lookahead >= 'a' && lexer->lookahead <= 'f') ||
         (lexer->lookahead >= 'A' && lexer->lookahead <= 'F')) {
    lexer->advance(lexer, false);
    digits++;
  }
  if (goes_on(lexer->lookahead) || (digits != 3 && digits != 6 && digits != 8)) return false;
  lexer->mark_end(lexer);
  lexer->result_symbol = COLOR;
  return true;
}

// Whether an item may end here; `last` is how it would, `like` whether that word would go on with it.
static bool end(TSLexer *lexer, enum Token last, bool like) {
  lexer->mark_end(lexer);
  lexer->result_symbol = last;
  bool new_line = false;
  for (;;) {
    if (lexer->eof(lexer)) return true;
    int32_t c = lexer->lookahead;
    if (is_space(c)) {
      new_line |= c == '\n';
      lexer->advance(lexer, false);
      continue;
    }
    if (c == '/') {
      lexer->advance(lexer, false);
      if (lexer->lookahead == '/') {
        while (!lexer->eof(lexer) && lexer->lookahead != '\n') lexer->advance(lexer, false);
      } else if (lexer->lookahead == '*') {
        lexer->advance(lexer, false);
        for (int32_t before = 0; !lexer->eof(lexer);) {
          int32_t here = lexer->lookahead;
          new_line |= here == '\n';
          lexer->advance(lexer, false);
          if (before == '*' && here == '/') break;
          before = here;
        }
      } else {
        return false;
      }
      continue;
    }
    if (c == ',' || c == ';' || c == '}') return true;
    if (!new_line) return false;
    if (c == '"') return true;
    if (!starts_name(c)) return false;
    char word[8];
    read_word(lexer, word);
    static const char *const IN[] = {"in"}, *const AS[] = {"as"}, *const LIKE[] = {"like"};
    if (last == PARAM_END && is_word(word, IN, 1)) return false;
    if (last == IMPORT_END && is_word(word, AS, 1)) return false;
    return !(like && is_word(word, LIKE, 1));
  }
}

bool tree_sitter_kinora_external_scanner_scan(void *payload, TSLexer *lexer, const bool *valid) {
  (void)payload;
  if (valid[ERROR]) return color(lexer);
  if (valid[UNIT]) return unit(lexer);
  if (valid[GLUED] && !lexer->eof(lexer) && starts_name(lexer->lookahead)) {
    lexer->mark_end(lexer);
    lexer->result_symbol = GLUED;
    return true;
  }
  if (valid[PARAM_END]) return end(lexer, PARAM_END, valid[BODY_MAY_FOLLOW]);
  if (valid[IMPORT_END]) return end(lexer, IMPORT_END, valid[BODY_MAY_FOLLOW]);
  if (valid[END]) return end(lexer, END, valid[BODY_MAY_FOLLOW]);
  return valid[COLOR] && color(lexer);
}
