;;; kinora-mode.el --- The Kinora scene language  -*- lexical-binding: t; -*-

;; Version: 0.1.0
;; Package-Requires: ((emacs "26.1"))
;; Keywords: languages
;; URL: https://github.com/kinora/kinora
;; SPDX-License-Identifier: MIT OR Apache-2.0

;;; Commentary:

;; Colours, comments and indentation of .kin files.  All else is done by `kinora lsp', with eglot:
;; docs/editors/emacs.md.  The lists between `begin' and `end' are written by lang/tests/editors.rs.

;;; Code:

(defgroup kinora nil "The Kinora scene language." :group 'languages)

(defcustom kinora-indent-offset 4 "Columns of one level." :type 'integer :safe #'integerp)

(defcustom kinora-program "kinora" "The program: a name in the path, or a file." :type 'string)

(defconst kinora-mode--keywords
  '(
    ;; begin keywords
    "after" "as" "ease" "else" "false" "fn" "for" "from" "if" "import" "in" "keys" "lang" "let"
    "like" "param" "prefab" "return" "true"
    ;; end keywords
    ))

(defconst kinora-mode--kinds
  '(
    ;; begin kinds
    "box" "camera" "capsule" "cloth" "cone" "cylinder" "denoise" "dielectric" "diffuse" "disk"
    "emitter" "fluid" "forces" "ggx" "glossy" "group" "instance" "joint" "mesh" "metal" "mix"
    "model" "override" "plane" "point_light" "quad" "render" "rigid_body" "sheen" "simulation"
    "sky" "sphere" "spot_light" "sun" "torus"
    ;; end kinds
    ))

(defconst kinora-mode--functions
  '(
    ;; begin functions
    "abs" "acos" "asin" "atan" "atan2" "axis_angle" "blackbody" "ceil" "cell" "cell_id" "checker"
    "clamp" "cos" "count" "cross" "distance" "dot" "euler" "exp" "f_number" "face_towards" "fbm"
    "floor" "fract" "hsv" "image" "length" "linear" "log" "look_at" "max" "min" "mix" "mod" "node"
    "noise" "normal_map" "normalize" "oklch" "rand" "rotate_x" "rotate_y" "rotate_z" "round"
    "saturate" "sign" "sin" "smoothstep" "sqrt" "srgb" "step" "sum" "tan" "turn"
    ;; end functions
    ;; begin curves
    "bezier" "spring" "steps"
    ;; end curves
    ))

(defconst kinora-mode--eases
  '(
    ;; begin eases
    "ease_in" "ease_in_out" "ease_out" "hold" "in_back" "in_bounce" "in_circ" "in_cubic"
    "in_elastic" "in_expo" "in_out_back" "in_out_bounce" "in_out_circ" "in_out_cubic"
    "in_out_elastic" "in_out_expo" "in_out_quad" "in_out_quart" "in_out_quint" "in_out_sine"
    "in_quad" "in_quart" "in_quint" "in_sine" "linear" "out_back" "out_bounce" "out_circ"
    "out_cubic" "out_elastic" "out_expo" "out_quad" "out_quart" "out_quint" "out_sine" "smooth"
    "step"
    ;; end eases
    ))

(defconst kinora-mode--types
  '(
    ;; begin types
    "acceleration" "angle" "angular_speed" "area" "bool" "camera" "color" "damping" "density"
    "energy" "float" "force" "frequency" "impulse" "int" "irradiance" "length" "list" "mass"
    "material" "node" "power" "quat" "radiance" "range" "solid_angle" "speed" "stiffness" "string"
    "temperature" "texture" "time" "vec2" "vec3" "volume"
    ;; end types
    ))

(defconst kinora-mode--always
  '(
    ;; begin always
    "frame" "normal" "p" "p_local" "time" "uv"
    ;; end always
    ))

(defconst kinora-mode--font-lock
  `(("\\_<\\(?:fn\\)\\s-+\\(\\(?:\\sw\\|\\s_\\)+\\)" 1 font-lock-function-name-face)
    ("\\_<prefab\\s-+\\(\\(?:\\sw\\|\\s_\\)+\\)" 1 font-lock-type-face)
    ("\\_<\\(?:let\\|param\\)\\s-+\\(\\(?:\\sw\\|\\s_\\)+\\)" 1 font-lock-variable-name-face)
    ;; Before `:' every word is the name of a property; two of them in a row are none.
    ("\\_<\\(?:let\\|param\\)\\s-+\\(?:\\sw\\|\\s_\\)+\\s-*:\\s-*\\(\\(?:\\sw\\|\\s_\\)+\\)" 1 font-lock-type-face)
    ("\\(\\_<\\(?:\\sw\\|\\s_\\)+\\)\\s-*:" 1 font-lock-variable-name-face)
    (,(concat "\\_<ease\\s-+\\(" (regexp-opt kinora-mode--eases) "\\)\\_>") 1 font-lock-constant-face)
    (,(regexp-opt kinora-mode--keywords 'symbols) . font-lock-keyword-face)
    (,(concat (regexp-opt kinora-mode--functions 'symbols) "\\s-*(") 1 font-lock-builtin-face)
    (,(concat (regexp-opt kinora-mode--kinds 'symbols)
              "\\(?:\\s-+\\(\\(?:\\sw\\|\\s_\\)+\\)\\)?\\s-*\\(?:{\\|\\_<like\\_>\\)")
     (1 font-lock-type-face)
     (2 font-lock-function-name-face nil t))
    (,(concat "\\(?:->\\|:\\)\\s-*" (regexp-opt kinora-mode--types 'symbols) "\\s-*\\(?:[=,){]\\|$\\)")
     1 font-lock-type-face)
    (,(regexp-opt kinora-mode--always 'symbols) . font-lock-builtin-face)
    ("#[[:xdigit:]]+\\_>" . font-lock-constant-face)
    ("\\_<[0-9][0-9_]*\\(?:\\.[0-9][0-9_]*\\)?\\(?:[eE][-+]?[0-9]+\\)?\\(?:%\\|[[:alpha:]]+\\(?:\\^-?[0-9]\\)?\\(?:[/*][[:alpha:]]+\\(?:\\^-?[0-9]\\)?\\)*\\)?"
     . font-lock-constant-face)))

(defvar kinora-mode-syntax-table
  (let ((table (make-syntax-table)))
    (modify-syntax-entry ?_ "_" table)
    (modify-syntax-entry ?/ ". 124b" table)
    (modify-syntax-entry ?* ". 23" table)
    (modify-syntax-entry ?\n "> b" table)
    (modify-syntax-entry ?\" "\"" table)
    (modify-syntax-entry ?\\ "\\" table)
    (modify-syntax-entry ?' "." table)
    (dolist (sign '(?+ ?- ?< ?> ?= ?& ?| ?^ ?! ?% ?# ?. ?, ?\; ?:)) (modify-syntax-entry sign "." table))
    table))

(defun kinora-mode-indent-line ()
  "Indent the line by the brackets round it."
  (interactive)
  (let* ((from-end (- (point-max) (point)))
         (column
          (save-excursion
            (back-to-indentation)
            (let ((state (syntax-ppss))
                  ;; A line that goes on with the one before it.
                  (more (if (looking-at-p "[-+*^&|<>=]\\|/[^/*]") kinora-indent-offset 0)))
              (cond
               ;; A comment of several lines stays as it is.
               ((nth 4 state) (current-indentation))
               ((nth 1 state)
                (let ((closes (looking-at-p "[])}]")))
                  (goto-char (nth 1 state))
                  (+ (current-indentation) more (if closes 0 kinora-indent-offset))))
               (t more))))))
    (indent-line-to column)
    (when (> (- (point-max) from-end) (point)) (goto-char (- (point-max) from-end)))))

;;;###autoload
(define-derived-mode kinora-mode prog-mode "Kinora"
  "Major mode for the Kinora scene language."
  (setq-local font-lock-defaults '(kinora-mode--font-lock))
  (setq-local comment-start "// ")
  (setq-local comment-end "")
  (setq-local comment-start-skip "\\(?://+\\|/\\*+\\)\\s-*")
  (setq-local indent-line-function #'kinora-mode-indent-line)
  (setq-local indent-tabs-mode nil)
  (setq-local tab-width kinora-indent-offset)
  (setq-local electric-indent-chars (append "{}()[]" electric-indent-chars))
  (setq-local imenu-generic-expression
              '((nil "^\\s-*\\(?:fn\\|prefab\\|let\\|param\\)\\s-+\\(\\(?:\\sw\\|\\s_\\)+\\)" 1)
                ("Nodes" "^\\s-*\\(\\(?:\\sw\\|\\s_\\)+\\s-+\\(?:\\sw\\|\\s_\\)+\\)\\s-*\\(?:{\\|like\\)" 1)))
  (setq-local compile-command (concat kinora-program " check --format short .")))

;;;###autoload
(add-to-list 'auto-mode-alist '("\\.kin\\'" . kinora-mode))

(defvar eglot-server-programs)
(with-eval-after-load 'eglot
  (add-to-list 'eglot-server-programs
               `(kinora-mode . ,(lambda (&rest _) (list kinora-program "lsp")))))

(defun kinora-view ()
  "Open the file of this buffer in the viewer."
  (interactive)
  (save-buffer)
  (start-process "kinora view" "*kinora view*" kinora-program "view" (buffer-file-name)))

(defun kinora-render ()
  "Render the file of this buffer to a picture beside it."
  (interactive)
  (save-buffer)
  (let ((file (buffer-file-name)))
    (compile (format "%s render %s -o %s" (shell-quote-argument kinora-program) (shell-quote-argument file)
                     (shell-quote-argument (concat (file-name-sans-extension file) ".png"))))))

(provide 'kinora-mode)

;;; kinora-mode.el ends here
