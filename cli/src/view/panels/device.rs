//! What renders: the choice of a backend and of a device.

use std::sync::{Arc, Mutex, PoisonError};

use egui::{Label, RichText, Ui};
use kinora_renderer::gpu::{Adapter, Api, Gpu, adapters_of};
use kinora_renderer::{Backend, Options};

use super::Facts;
use crate::flags::{BackendName, PictureFlags, gpu_checks};

/// What is to render.
#[derive(Clone)]
pub enum Choice {
    /// By name, as `--backend` has it.
    Name(BackendName),
    /// This device.
    Adapter(Box<Adapter>),
}

impl Choice {
    /// The name that comes next to it, for the command line.
    pub fn name(&self) -> BackendName {
        match self {
            Choice::Name(name) => *name,
            Choice::Adapter(adapter) => match adapter.api {
                Api::Vulkan => BackendName::Vulkan,
                Api::Metal => BackendName::Metal,
                Api::Dx12 => BackendName::Dx12,
                Api::Gl => BackendName::Gl,
            },
        }
    }

    /// Opens it, with so many threads of the CPU.
    ///
    /// # Errors
    /// It is not there or does not work, in words.
    pub fn open(&self, picture: &PictureFlags) -> Result<Box<dyn Backend>, String> {
        match self {
            Choice::Name(name) => PictureFlags { backend: *name, ..picture.clone() }.open(),
            Choice::Adapter(adapter) => {
                let Options { checks, .. } = Options { threads: picture.threads, checks: gpu_checks() };
                Gpu::open(adapter, checks).map(|gpu| Box::new(gpu) as Box<dyn Backend>)
            }
        }
        .map_err(|error| error.to_string())
    }
}

/// The devices that there are.
#[derive(Default)]
pub struct Devices {
    found: Arc<Mutex<Option<Vec<Adapter>>>>,
    looked: bool,
}

impl Devices {
    /// Draws the choice; gives what is chosen.
    pub fn show(&mut self, ui: &mut Ui, facts: &Facts<'_>) -> Option<Choice> {
        let mut chosen = None;
        ui.add(Label::new(facts.device).wrap());
        for (name, what) in [(BackendName::Auto, "The best there is"), (BackendName::Cpu, "CPU")] {
            if ui.selectable_label(facts.backend == name, what).clicked() {
                chosen = Some(Choice::Name(name));
            }
        }
        if !self.looked {
            self.look(ui);
        }
        match &*self.found.lock().unwrap_or_else(PoisonError::into_inner) {
            None => drop(ui.label(RichText::new("looking for GPUs…").weak())),
            Some(adapters) if adapters.is_empty() => drop(ui.label(RichText::new("There is no GPU.").weak())),
            Some(adapters) => {
                for adapter in adapters {
                    let label = adapter.label();
                    let now = facts.device.contains(adapter.name());
                    let usable = adapter.check();
                    ui.add_enabled_ui(usable.is_ok(), |ui| {
                        let row = ui.selectable_label(now, label);
                        let row = match usable {
                            Ok(()) => row.on_hover_text(adapter.driver()),
                            Err(why) => row.on_disabled_hover_text(why.to_string()),
                        };
                        if row.clicked() {
                            chosen = Some(Choice::Adapter(Box::new(adapter.clone())));
                        }
                    });
                }
            }
        }
        if Api::Gl.is_built_in() && ui.selectable_label(facts.backend == BackendName::Gl, "OpenGL").clicked() {
            chosen = Some(Choice::Name(BackendName::Gl));
        }
        chosen
    }

    /// Looks for devices beside the window, as drivers take their time. OpenGL is not asked, which would take longer still.
    fn look(&mut self, ui: &Ui) {
        self.looked = true;
        let (found, context) = (self.found.clone(), ui.ctx().clone());
        std::thread::spawn(move || {
            let all = Api::ALL.into_iter().filter(|api| *api != Api::Gl && api.is_built_in()).flat_map(adapters_of);
            let all: Vec<Adapter> = all.collect();
            *found.lock().unwrap_or_else(PoisonError::into_inner) = Some(all);
            context.request_repaint();
        });
        ui.ctx().request_repaint_after(std::time::Duration::from_millis(200));
    }
}
