// The packed extension: `npm test` packs it first.

"use strict";

const assert = require("node:assert");
const fs = require("node:fs");
const Module = require("node:module");
const os = require("node:os");
const path = require("node:path");
const test = require("node:test");
const yauzl = require("yauzl");

const ROOT = path.join(__dirname, "..");
const manifest = JSON.parse(fs.readFileSync(path.join(ROOT, "package.json"), "utf8"));

/** Name and bytes of everything in the package. */
function unpacked() {
  const file = path.join(ROOT, `kinora-${manifest.version}.vsix`);
  const found = new Map();
  return new Promise((resolve, reject) =>
    yauzl.open(file, { lazyEntries: true }, (error, zip) => {
      if (error) return reject(error);
      zip.on("error", reject);
      zip.on("end", () => resolve(found));
      zip.on("entry", entry =>
        zip.openReadStream(entry, (failed, stream) => {
          if (failed) return reject(failed);
          const parts = [];
          stream.on("data", part => parts.push(part));
          stream.on("end", () => {
            found.set(entry.fileName, Buffer.concat(parts));
            zip.readEntry();
          });
        }),
      );
      zip.readEntry();
    }),
  );
}

/** Everything in a value that is a path of the package. */
function paths(value) {
  if (typeof value === "string") return value.startsWith("./") ? [value.slice(2)] : [];
  return value && typeof value === "object" ? Object.values(value).flatMap(paths) : [];
}

test("all parts are inside, and nothing else", async () => {
  const found = await unpacked();
  const named = paths(manifest);
  assert(named.length >= 5, `${named}`);
  for (const name of named) assert(found.has(`extension/${name}`), name);
  const names = [...found.keys()].map(name => name.toLowerCase()).sort();
  assert.deepEqual(names, [
    "[content_types].xml",
    "extension.vsixmanifest",
    "extension/changelog.md",
    "extension/dist/extension.js",
    "extension/language-configuration.json",
    "extension/license.txt",
    "extension/package.json",
    "extension/readme.md",
    "extension/schemas/kinora.toml.schema.json",
    "extension/snippets/kinora.json",
    "extension/syntaxes/codeblock.json",
    "extension/syntaxes/kinora.tmlanguage.json",
  ]);
  for (const [name, bytes] of found) if (name.endsWith(".json")) JSON.parse(bytes.toString("utf8"));
});

test("commands, tasks and settings that are declared are there", async () => {
  const bundle = (await unpacked()).get("extension/dist/extension.js").toString("utf8");
  for (const { command } of manifest.contributes.commands) assert(bundle.includes(command), command);
  for (const { type } of manifest.contributes.taskDefinitions) assert.equal(type, "kinora");
  for (const name of Object.keys(manifest.contributes.configuration.properties)) assert(name.startsWith("kinora."), name);
});

test("the problem matcher reads what the program prints", () => {
  const { pattern } = manifest.contributes.problemMatchers[0];
  const printed = fs.readFileSync(path.join(__dirname, "short.txt"), "utf8").trim().split(/\r?\n/);
  assert(printed.length > 1);
  for (const line of printed) {
    const match = new RegExp(pattern.regexp).exec(line);
    assert(match, line);
    assert.equal(match[pattern.file], "scenes/a.kin");
    assert(Number(match[pattern.line]) > 0 && Number(match[pattern.column]) > 0);
    assert.match(match[pattern.severity], /^(error|warning)$/);
    assert.match(match[pattern.code], /^[EW]\d{4}$/);
    assert(match[pattern.message].length > 0);
  }
  const windows = new RegExp(pattern.regexp).exec("C:\\scenes\\a.kin:3:24: error[E0118]: a: b");
  assert.equal(windows[pattern.file], "C:\\scenes\\a.kin");
});

test("patterns of the language's configuration are right", () => {
  const settings = JSON.parse(fs.readFileSync(path.join(ROOT, "language-configuration.json"), "utf8"));
  const word = new RegExp(settings.wordPattern.pattern, `g${settings.wordPattern.flags}`);
  assert.deepEqual("radius: 9.81m/s^2 + größe.x #d9402b".match(word), ["radius", "9.81m/s^2", "größe", "x", "#d9402b"]);
  const more = new RegExp(settings.indentationRules.increaseIndentPattern);
  assert(more.test("sphere ball {") && more.test("sphere { // (") && !more.test("sphere { }") && !more.test("// {"));
  assert(new RegExp(settings.indentationRules.decreaseIndentPattern).test("    }"));
  const [docs] = settings.onEnterRules;
  assert(new RegExp(docs.beforeText).test("    /// What") && !new RegExp(docs.beforeText).test("//// What"));
});

/** Everything that can be asked for: classes, functions and constants, all of them doing nothing. */
function anything(own) {
  const nothing = function () {};
  return new Proxy(nothing, {
    get: (_, name) => {
      if (name in own) return own[name];
      if (name === "prototype") return nothing.prototype;
      if (name === Symbol.toPrimitive) return () => "";
      if (name === "then") return undefined;
      return anything({});
    },
    construct: () => ({}),
    apply: () => anything({}),
  });
}

test("the bundle loads, registers its commands, and says that the program is missing", async () => {
  const bundle = (await unpacked()).get("extension/dist/extension.js");
  const folder = fs.mkdtempSync(path.join(os.tmpdir(), "kinora-"));
  const file = path.join(folder, "extension.js");
  fs.writeFileSync(file, bundle);
  const commands = [], said = [], types = [];
  const vscode = anything({
    commands: { registerCommand: name => (commands.push(name), { dispose() {} }) },
    tasks: { registerTaskProvider: type => (types.push(type), { dispose() {} }) },
    window: anything({ showErrorMessage: async message => void said.push(message) }),
    workspace: anything({
      isTrusted: true,
      getConfiguration: () => ({ get: () => path.join(folder, "no-such-program") }),
    }),
  });
  const load = Module._load;
  Module._load = (name, ...rest) => (name === "vscode" ? vscode : load(name, ...rest));
  try {
    const extension = require(file);
    await extension.activate({ subscriptions: [] });
    await extension.deactivate();
  } finally {
    Module._load = load;
    fs.rmSync(folder, { recursive: true });
  }
  assert.deepEqual(commands.sort(), manifest.contributes.commands.map(one => one.command).sort());
  assert.deepEqual(types, ["kinora"]);
  assert.equal(said.length, 1);
  assert.match(said[0], /no-such-program` was not found/);
});
