//! Tells Zed how `kinora lsp` is started: as the settings say, or as `kinora` in the path.

use zed_extension_api::settings::LspSettings;
use zed_extension_api::{register_extension, Command, Extension, LanguageServerId, Result, Worktree};

struct Kinora;

impl Extension for Kinora {
    fn new() -> Kinora {
        Kinora
    }

    fn language_server_command(&mut self, _: &LanguageServerId, worktree: &Worktree) -> Result<Command> {
        let binary = LspSettings::for_worktree("kinora", worktree).ok().and_then(|settings| settings.binary);
        let (path, arguments) = binary.map_or((None, None), |binary| (binary.path, binary.arguments));
        let missing = || {
            "`kinora` is not in the path: see https://github.com/kinora/kinora/blob/main/docs/install.md, or name it in \
             the settings under lsp.kinora.binary.path"
        };
        Ok(Command {
            command: path.or_else(|| worktree.which("kinora")).ok_or_else(missing)?,
            args: arguments.unwrap_or_else(|| vec!["lsp".into()]),
            env: worktree.shell_env(),
        })
    }
}

register_extension!(Kinora);
