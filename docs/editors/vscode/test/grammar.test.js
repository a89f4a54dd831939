// The grammar, read by VS Code's own tokenizer.

"use strict";

const assert = require("node:assert");
const fs = require("node:fs");
const path = require("node:path");
const test = require("node:test");
const oniguruma = require("vscode-oniguruma");
const textmate = require("vscode-textmate");

const ROOT = path.join(__dirname, "..");
const EXAMPLES = path.join(ROOT, "../../../examples");

const wasm = fs.readFileSync(path.join(path.dirname(require.resolve("vscode-oniguruma")), "onig.wasm"));
const registry = new textmate.Registry({
  onigLib: oniguruma.loadWASM(wasm.buffer.slice(wasm.byteOffset, wasm.byteOffset + wasm.length)).then(() => ({
    createOnigScanner: patterns => new oniguruma.OnigScanner(patterns),
    createOnigString: text => new oniguruma.OnigString(text),
  })),
  loadGrammar: async scope => {
    const file = { "source.kinora": "kinora.tmLanguage.json", "markdown.kinora.codeblock": "codeblock.json" }[scope];
    if (!file) return null;
    const at = path.join(ROOT, "syntaxes", file);
    return textmate.parseRawGrammar(fs.readFileSync(at, "utf8"), at);
  },
});

/** The tokens of a text, line by line: text and scopes. */
async function lines(text, scope = "source.kinora") {
  const grammar = await registry.loadGrammar(scope);
  let state = textmate.INITIAL;
  const all = text.split(/\r?\n/).map(line => {
    const found = grammar.tokenizeLine(line, state);
    assert(!found.stoppedEarly);
    state = found.ruleStack;
    return found.tokens.map(token => ({ text: line.slice(token.startIndex, token.endIndex), scopes: token.scopes }));
  });
  return { all, depth: state.depth };
}

/** Pairs of a word and what its innermost scope begins with; words that come twice are told apart by order. */
async function check(text, expected) {
  const tokens = (await lines(text)).all.flat();
  let at = 0;
  for (const [word, scope] of expected) {
    const found = tokens.findIndex((token, i) => i >= at && token.text.trim() === word);
    assert(found >= 0, `no \`${word}\` in ${JSON.stringify(tokens.map(token => token.text))}`);
    at = found + 1;
    const inner = tokens[found].scopes.at(-1);
    assert(inner.startsWith(scope), `\`${word}\` in \`${text}\` is ${inner}, not ${scope}`);
  }
}

test("words", async () => {
  await check("lang 1", [["lang", "keyword.other.lang"], ["1", "constant.numeric"]]);
  await check('import "std/metals" as metals', [
    ["import", "keyword.control.import"], ["std/metals", "string.quoted"], ["as", "keyword.control.import"],
    ["metals", "variable.other"],
  ]);
  await check("param rough: float = 0.25 in 0..1", [
    ["param", "storage.type"], ["rough", "variable.other.constant"], ["float", "support.type"], ["=", "keyword.operator"],
    ["0.25", "constant.numeric"], ["in", "keyword.control"], ["..", "keyword.operator"],
  ]);
  await check("sphere ball { radius: 50cm, material: metals.gold }", [
    ["sphere", "support.class"], ["ball", "entity.name.tag"], ["radius", "support.type.property-name"],
    ["50", "constant.numeric"], ["cm", "keyword.other.unit"], ["material", "support.type.property-name"],
    ["metals", "variable.other"], ["gold", "variable.other.member"],
  ]);
  await check("wall left { at: (0, -9.81m/s^2, 3m/steps, 30degrees) }", [
    ["wall", "entity.name.type"], ["left", "entity.name.tag"], ["at", "variable.other.property"],
    ["m/s^2", "keyword.other.unit"], ["m", "keyword.other.unit"], ["/", "keyword.operator"], ["steps", "variable.other"],
    ["degrees", "invalid.illegal.unit"],
  ]);
  await check("diffuse red like white { color: #d9402b } // c", [
    ["diffuse", "support.class"], ["red", "entity.name.tag"], ["like", "keyword.other"], ["white", "entity.name.type"],
    ["color", "support.type.property-name"], ["d9402b", "constant.other.color"], ["//", "punctuation.definition.comment"],
  ]);
  await check("let a: list<length> = [1m]", [["a", "variable.other"], ["list", "support.type"], ["length", "support.type"]]);
  await check("tonemap: agx", [["tonemap", "support.type.property-name"], [":", "punctuation"], ["agx", "support.constant"]]);
  await check("2s: (1, 2) ease in_out_cubic", [["ease", "keyword.other"], ["in_out_cubic", "support.constant.ease"]]);
  await check("8s: 1 ease bezier(0, 0, 1, 1)", [["bezier", "support.function"]]);
  await check("fn f(i: int) -> vec3 { return rotate_y(time * i) }", [
    ["fn", "storage.type.function"], ["f", "entity.name.function"], ["i", "variable.other"], ["int", "support.type"],
    ["->", "keyword.operator"], ["vec3", "support.type"], ["return", "keyword.control"], ["rotate_y", "support.function"],
    ["time", "variable.language"],
  ]);
  await check("if a < b { x { } } else if c { y { } }", [
    ["if", "keyword.control"], ["a", "variable.other"], ["b", "variable.other"], ["x", "entity.name.type"],
    ["else", "keyword.control"], ["if", "keyword.control"], ["c", "variable.other"], ["y", "entity.name.type"],
  ]);
  await check("for i in 0..count { a { b: [for j in list if j > 1: sphere { }] } }", [
    ["in", "keyword.control"], ["count", "variable.other.kinora"], ["a", "entity.name.type"], ["for", "keyword.control"],
    ["list", "variable.other"], ["if", "keyword.control"], [":", "punctuation"], ["sphere", "support.class"],
  ]);
  await check("0s: { value: 1, in: 0, out: 2 }", [
    ["value", "variable.other.property"], ["in", "variable.other.property"], ["out", "variable.other.property"],
  ]);
  await check("/// What it is.", [["What it is.", "comment.line.documentation"]]);
  await check('a: "x\\n\\q"', [["\\n", "constant.character.escape"], ["\\q", "invalid.illegal.escape"]]);
  await check("let a = #12345", [["#12345", "invalid.illegal.color"]]);
});

test("an open string ends with its line, a comment does not", async () => {
  const string = await lines('a: "b\nradius: 1');
  assert.equal(string.all[1][0].scopes.at(-1), "support.type.property-name.kinora");
  const comment = await lines("/* a\n b */ radius: 1");
  assert(comment.all[1][0].scopes.includes("comment.block.kinora"));
  assert.equal(comment.all[1].find(token => token.text === "radius").scopes.at(-1), "support.type.property-name.kinora");
});

test("every example", async () => {
  const files = fs.readdirSync(EXAMPLES, { recursive: true }).filter(file => file.endsWith(".kin"));
  assert(files.length > 15);
  for (const file of files) {
    const text = fs.readFileSync(path.join(EXAMPLES, file), "utf8");
    const { all, depth } = await lines(text);
    assert.equal(depth, 1, `${file}: something is open at the end`);
    all.forEach((line, i) => {
      for (const token of line) {
        const place = `${file}:${i + 1}: \`${token.text}\``;
        assert(!token.scopes.some(scope => scope.startsWith("invalid")), `${place} is ${token.scopes}`);
        if (/\S/.test(token.text)) assert(token.scopes.length > 1, `${place} has no scope`);
      }
    });
  }
});

test("blocks in Markdown", async () => {
  const { all } = await lines("```kin fragment\nsphere { radius: 1 }\n```\nradius: 1", "markdown.kinora.codeblock");
  assert(all[1].some(token => token.text === "sphere" && token.scopes.includes("support.class.kinora")));
  assert(all[1].every(token => token.scopes.includes("meta.embedded.block.kinora")));
  assert(!all[3].some(token => token.scopes.includes("meta.embedded.block.kinora")));
});
