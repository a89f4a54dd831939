// Starts `kinora lsp` and the commands. All knowledge of the language is in the program.

"use strict";

const { execFile } = require("node:child_process");
const path = require("node:path");
const vscode = require("vscode");
const { LanguageClient } = require("vscode-languageclient/node");

const INSTALL = "https://github.com/kinora/kinora/blob/main/docs/install.md";

/** @type {LanguageClient | undefined} */
let client;
/** Of the files that scenes read. */
let watcher;
/** Starts and stops, one after another. */
let turn = Promise.resolve();

function program() {
  const named = vscode.workspace.getConfiguration("kinora").get("path", "kinora").trim() || "kinora";
  return named.startsWith("~/") ? path.join(require("node:os").homedir(), named.slice(2)) : named;
}

/** Nothing, or why the program cannot do this. */
function whyNot(command, what) {
  return new Promise(resolve => {
    execFile(command, [what, "--help"], { timeout: 10_000, windowsHide: true }, error => {
      if (!error) return resolve(undefined);
      if (error.code === "ENOENT") return resolve(`The program \`${command}\` was not found.`);
      if (error.code === "EACCES") return resolve(`\`${command}\` is not a program that may be run.`);
      resolve(`\`${command} ${what}\` does not work: the program may be an older one. ${error.message}`);
    });
  });
}

async function complain(message) {
  const settings = "Open Settings", install = "How to Install";
  const chosen = await vscode.window.showErrorMessage(
    `Kinora: ${message} Colours and snippets work without it; the setting kinora.path says where it is.`,
    settings, install,
  );
  if (chosen === settings) await vscode.commands.executeCommand("workbench.action.openSettings", "kinora.path");
  if (chosen === install) await vscode.env.openExternal(vscode.Uri.parse(INSTALL));
}

async function start() {
  const command = program();
  const problem = await whyNot(command, "lsp");
  if (problem) {
    // Not awaited: it stays until it is read.
    void complain(problem);
    return;
  }
  client = new LanguageClient(
    "kinora",
    "Kinora",
    { command, args: ["lsp"] },
    {
      documentSelector: [
        { language: "kinora", scheme: "file" },
        { language: "kinora", scheme: "untitled" },
      ],
      synchronize: { fileEvents: watcher },
    },
  );
  try {
    await client.start();
  } catch (error) {
    void complain(`\`${command} lsp\` did not start: ${error.message}`);
  }
}

async function stop() {
  const old = client;
  client = undefined;
  try {
    await old?.stop();
  } catch {
    // It has ended already.
  }
}

function restart() {
  turn = turn.then(stop).then(start);
  return turn;
}

/** The scene of a command: the file that was clicked, or that of the editor, saved. */
async function scene(uri) {
  const open = vscode.window.activeTextEditor?.document;
  const target = uri instanceof vscode.Uri ? uri : open?.uri;
  if (!target || target.scheme !== "file") {
    void vscode.window.showErrorMessage("Kinora: save the scene as a file first.");
    return undefined;
  }
  const document = vscode.workspace.textDocuments.find(one => one.uri.toString() === target.toString());
  if (document?.isDirty) await document.save();
  return target;
}

/** Runs the program on a scene as a task, which has a terminal; nothing where it cannot be run. */
async function run(uri, args, reveal) {
  const problem = await whyNot(program(), args[0]);
  if (problem) {
    void complain(problem);
    return undefined;
  }
  const file = uri.fsPath;
  const folder = vscode.workspace.getWorkspaceFolder(uri);
  const task = new vscode.Task(
    { type: "kinora", command: args[0], paths: [file] },
    folder ?? vscode.TaskScope.Workspace,
    `${args[0]} ${path.basename(file)}`,
    "kinora",
    new vscode.ProcessExecution(program(), args, { cwd: path.dirname(file) }),
    [],
  );
  task.presentationOptions = { reveal, panel: vscode.TaskPanelKind.Dedicated, showReuseMessage: false };
  return vscode.tasks.executeTask(task);
}

async function view(uri) {
  const target = await scene(uri);
  if (target) await run(target, ["view", target.fsPath], vscode.TaskRevealKind.Silent);
}

async function render(uri) {
  const target = await scene(uri);
  if (!target) return;
  const picture = target.fsPath.replace(/\.kin$/, "") + ".png";
  const running = await run(target, ["render", target.fsPath, "-o", picture], vscode.TaskRevealKind.Always);
  if (!running) return;
  const listener = vscode.tasks.onDidEndTaskProcess(async ended => {
    if (ended.execution !== running) return;
    listener.dispose();
    if (ended.exitCode === 0) await vscode.commands.executeCommand("vscode.open", vscode.Uri.file(picture));
  });
}

/** `kinora check` and `kinora test` of a folder. */
function task(definition, scope) {
  const paths = definition.paths?.length ? definition.paths : ["."];
  const format = definition.command === "check" ? ["--format", "short"] : [];
  const made = new vscode.Task(
    definition,
    scope,
    `${definition.command} ${paths.join(" ")}`,
    "kinora",
    new vscode.ProcessExecution(program(), [definition.command, ...paths, ...format]),
    definition.command === "check" ? ["$kinora"] : [],
  );
  made.group = definition.command === "check" ? vscode.TaskGroup.Build : vscode.TaskGroup.Test;
  return made;
}

const tasks = {
  provideTasks() {
    const folders = vscode.workspace.workspaceFolders ?? [];
    return folders.flatMap(folder =>
      ["check", "test"].map(command => task({ type: "kinora", command }, folder)),
    );
  },
  resolveTask(found) {
    return task(found.definition, found.scope ?? vscode.TaskScope.Workspace);
  },
};

function activate(context) {
  watcher = vscode.workspace.createFileSystemWatcher("**/{*.kin,kinora.toml}");
  context.subscriptions.push(
    watcher,
    vscode.commands.registerCommand("kinora.view", view),
    vscode.commands.registerCommand("kinora.render", render),
    vscode.commands.registerCommand("kinora.restart", restart),
    vscode.tasks.registerTaskProvider("kinora", tasks),
    vscode.workspace.onDidChangeConfiguration(change => {
      if (change.affectsConfiguration("kinora.path")) void restart();
    }),
    vscode.workspace.onDidGrantWorkspaceTrust(() => void restart()),
  );
  return vscode.workspace.isTrusted ? restart() : undefined;
}

function deactivate() {
  turn = turn.then(stop);
  return turn;
}

module.exports = { activate, deactivate };
