(* eva_report.ml - what Eva has found, a line each, for tests/check_eva.py:

     reached FUNCTION FILE       unreached FUNCTION FILE
     statements REACHED OF FUNCTION FILE
     dead FILE:LINE FUNCTION     a line with a statement that no input of the driver reaches
     open FILE:LINE WHAT         an alarm or another property without proof
     false FILE:LINE WHAT        one that no input fulfils: what comes after it is not analysed
     valid N                     properties that are proved *)

open Cil_types

let place (at : Cil_types.location) =
  let pos = fst at in
  Printf.sprintf "%s:%d" (Filepath.Normalized.to_pretty_string pos.Filepath.pos_path) pos.Filepath.pos_lnum

let file_of kf = Filepath.Normalized.to_pretty_string (fst (Kernel_function.get_location kf)).Filepath.pos_path

let statements kf =
  let all = ref 0 and reached = ref 0 and dead = ref [] in
  let one s =
    match s.skind with
    | Block _ | UnspecifiedSequence _ -> ()
    | _ ->
      incr all;
      if Eva.Results.is_reachable s then incr reached
      else dead := place (Cil_datatype.Stmt.loc s) :: !dead
  in
  List.iter one (Kernel_function.get_definition kf).sallstmts;
  let name = Kernel_function.get_name kf in
  Printf.printf "statements %d %d %s %s\n" !reached !all name (file_of kf);
  List.iter (fun at -> Printf.printf "dead %s %s\n" at name) (List.sort_uniq compare !dead)

let functions () =
  let one kf =
    if Kernel_function.is_definition kf then
      if Eva.Results.is_called kf then begin
        Printf.printf "reached %s %s\n" (Kernel_function.get_name kf) (file_of kf);
        statements kf
      end
      else Printf.printf "unreached %s %s\n" (Kernel_function.get_name kf) (file_of kf)
  in
  Globals.Functions.iter one

let properties () =
  let valid = ref 0 in
  let one ip =
    match Property_status.get ip with
    | Property_status.Best (Property_status.True, _) -> incr valid
    | Property_status.Never_tried -> ()
    | status ->
      let text = Format.asprintf "%a" Property.pretty ip in
      let text = String.concat " " (List.filter (fun w -> w <> "") (String.split_on_char ' '
        (String.map (fun c -> if c = '\n' then ' ' else c) text))) in
      let said = match status with
        | Property_status.Best ((Property_status.False_if_reachable | Property_status.False_and_reachable), _) -> "false"
        | _ -> "open"
      in
      Printf.printf "%s %s %s\n" said (place (Property.location ip)) text
  in
  Property_status.iter one;
  Printf.printf "valid %d\n" !valid

let main () =
  if Db.Value.is_computed () then begin
    functions ();
    properties ();
    flush stdout
  end

let () = Db.Main.extend main
